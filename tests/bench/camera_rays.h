// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/ray.h"
#include "octree/query.h"

// The rays that a renderer casts, without a renderer.

namespace alidade::bench {

/// A pinhole camera's rays through the centres of 600 x 400 pixels, row by row, 60 degrees high. They start
/// at t = 0.
std::vector<Ray> camera_rays(const glm::dvec3& eye, const glm::dvec3& target);

/// A point on the sphere of a hit, and the outward normal there: rays of the next bounce leave from it.
struct BounceOrigin {
  glm::dvec3 position, normal;
};

/// Those of the rays that hit, in their order.
std::vector<BounceOrigin> bounce_origins(std::span<const Ray> rays, std::span<const std::optional<Hit>> hits);

/// One ray from each origin, its direction spread by the cosine around the normal.
std::vector<Ray> bounce_rays(std::span<const BounceOrigin> origins, std::uint64_t seed);

/// Parallel rays, one from each origin that faces `direction`: a renderer casts no others.
std::vector<Ray> parallel_rays(std::span<const BounceOrigin> origins, const glm::dvec3& direction);

/// In random order.
std::vector<Ray> shuffled(std::vector<Ray> rays, std::uint64_t seed);

}  // namespace alidade::bench
