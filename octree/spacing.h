// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/huge_memory.h"
#include "base/progress.h"
#include "octree/octree.h"
#include "octree/query.h"

namespace alidade {

/// World positions of at most `sample_count` points (and at least half as many where there are), taken evenly
/// in octree order, so every position counts by its number of points. Deterministic. Cost: one pass over the
/// leaves. max_level: only points of the levels 0 to max_level (of a layered octree).
std::vector<glm::dvec3> sample_positions(const Octree& octree, std::size_t sample_count,
                                         int max_level = k_all_levels);

/// Distances to the nearest other point, over a sample of positions.
struct Spacing {
  double median = 0.0;         ///< metres
  double percentile_90 = 0.0;  ///< metres
  double mean = 0.0;           ///< metres
  std::size_t sample_count = 0;
};

/// Measures nearest-neighbour spacing at the positions of up to `sample_count` points taken evenly in octree
/// order. Each position counts once, however many points it has: half of a scan may be invalid points at
/// zero. Points at the same position are no neighbours of each other. A cloud of fewer than two distinct
/// positions gives zeros. Deterministic. Cost: microseconds per position. max_level: of the cloud that these
/// levels of a layered octree make.
Spacing measure_spacing(const Octree& octree, std::size_t sample_count = 20000, int max_level = k_all_levels);

/// Sphere radius that closes a scanned surface: the renderer's "radius": "auto". Always > 0: where no
/// spacing can be measured it is a thousandth of the bounds' diagonal, or 0.01 if that is zero too.
double automatic_radius(const Octree& octree, int max_level = k_all_levels);

// How far the points of a cloud are from each other, point by point: what SurfaceQuery::spacing_factor
// (surface/surface_cloud.h) makes radii of.
//
// The spacing of a point is the distance to its n-th nearest neighbour: of the points that are at another
// position, nearest first, the n-th; infinite if there are fewer. It is rounded up to eight significant bits
// (by at most 0.8 %), and that number is what all queries take as the spacing.

constexpr int k_most_spacing_neighbours = 64;

/// This octree with the spacing of every point. An octree that has them for this n is returned as it is.
/// `progress` is in points. Cost: 0.2 microseconds of one thread per point (n = 8), in parallel; 2 B per
/// point and 32 B per node. Errors: n below 1 or above k_most_spacing_neighbours.
Octree with_spacings(const Octree& octree, int neighbours, const Progress& progress = {});

/// The 16 bits that represent a spacing, rounded up. Requires: not negative, not NaN.
std::uint16_t spacing_bits(double metres);

/// What 16 bits of a spacing represent, metres; infinity is possible.
inline float spacing_of(std::uint16_t bits) {
  return std::bit_cast<float>(std::uint32_t{bits} << 16);
}

/// Spacing of the point at a storage index. Requires spacings.
inline double spacing_at(const PointLayers& layers, std::uint32_t index) {
  return spacing_of(layers.spacings[index]);
}

/// The spacings by point id, metres, in Octree::scratch(). Requires spacings. Cost: linear.
HugeVector<float> spacings_in_order(const Octree& octree);

/// The greatest spacings below the slots of a node, as PointLayers::slot_spacings has them; 0 for empty
/// slots. Of the layers, slot spacings of the nodes behind this one are read, among which its children are.
inline std::array<std::uint16_t, k_node_width> greatest_spacings(const TreeView& tree,
                                                                 const PointLayers& layers,
                                                                 std::uint32_t node_index) {
  const Node& node = tree.nodes[node_index];
  std::uint32_t first_point = node.first_point;
  std::uint64_t child = node.first_child;
  std::array<std::uint16_t, k_node_width> greatest{};
  for (int slot = 0; slot < k_node_width; ++slot) {
    const std::uint8_t kind = node.kind[slot];
    // The bits of floats that are not negative have the order of the numbers.
    if (is_inner(kind)) {
      const std::uint16_t* below = layers.slot_spacings + k_node_width * child++;
      greatest[slot] = *std::max_element(below, below + k_node_width);
    } else if (is_leaf(kind)) {
      greatest[slot] = *std::max_element(layers.spacings + first_point, layers.spacings + first_point + kind);
      first_point += kind;
    }
  }
  return greatest;
}

}  // namespace alidade
