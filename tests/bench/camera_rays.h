// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/ray.h"
#include "octree/query.h"

// The rays a renderer asks, without a renderer.

namespace alidade::bench {

/// A pinhole camera's rays through the centres of 600 x 400 pixels, row by row, 60 degrees high. They start
/// at t = 0.
std::vector<Ray> camera_rays(const glm::dvec3& eye, const glm::dvec3& target);

/// Where each ray's hit lies, for those that hit: the rays of the next bounce leave from there.
struct SpherePosition {
  glm::dvec3 position, normal;
};
std::vector<SpherePosition> hit_positions(std::span<const Ray> rays,
                                          std::span<const std::optional<Hit>> hits);

/// One ray from each position, its direction spread by the cosine around the normal.
std::vector<Ray> bounce_rays(std::span<const SpherePosition> positions, std::uint64_t seed);

/// Parallel rays, one from each position that faces `direction`: a renderer casts no others.
std::vector<Ray> parallel_rays(std::span<const SpherePosition> positions, const glm::dvec3& direction);

/// In random order.
std::vector<Ray> shuffled(std::vector<Ray> rays, std::uint64_t seed);

}  // namespace alidade::bench
