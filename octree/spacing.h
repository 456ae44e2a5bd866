// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "octree/octree.h"
#include "octree/query.h"

namespace alidade {

/// World positions of at most `sample_count` points (and at least half as many where there are), taken evenly
/// in octree order, so every place counts by its number of points. Deterministic. Cost: one pass over the
/// leaves. max_level: only points of the levels 0 to max_level (of a layered octree).
std::vector<glm::dvec3> sample_positions(const Octree& octree, std::size_t sample_count,
                                         int max_level = k_all_levels);

/// Distances to the nearest other point, over a sample of points.
struct Spacing {
  double median = 0.0;         ///< metres
  double percentile_90 = 0.0;  ///< metres
  double mean = 0.0;           ///< metres
  std::size_t sample_count = 0;
};

/// Measures nearest-neighbour spacing on up to `sample_count` points taken evenly in octree order (so every
/// place counts by its number of points). Points at the same place are no neighbours of each other. A cloud
/// of fewer than two distinct places gives zeros. Deterministic. Cost: microseconds per sample. max_level: of
/// the cloud that these levels of a layered octree make.
Spacing measure_spacing(const Octree& octree, std::size_t sample_count = 20000, int max_level = k_all_levels);

/// Sphere radius that closes a scanned surface: the renderer's "radius": "auto". Always > 0: where no
/// spacing can be measured it is a thousandth of the bounds' diagonal, or 0.01 if that is zero too.
double automatic_radius(const Octree& octree, int max_level = k_all_levels);

}  // namespace alidade
