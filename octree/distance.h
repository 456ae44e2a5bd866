// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "octree/ray.h"

// The formulas of the paper (Teuscher et al. 2026, section 3.2). This is the only place where they stand:
// brute force, the index and every outer layer decide with these functions, so their answers are the same
// bits. Floating-point contraction must be off wherever this header is compiled, otherwise a fused
// multiply-add rounds differently from machine to machine.

namespace alidade {

/// Where a point lies relative to a ray. All lengths in metres (the unit of the CRS).
struct RayProjection {
  double t = 0.0;         ///< place of the orthogonal projection on the ray (eq. 2)
  double distance = 0.0;  ///< orthogonal distance to the ray's line (eq. 1)
};

/// Projects a world point on a ray whose direction has length 1.
inline RayProjection project(const Ray& ray, const glm::dvec3& point) {
  const double x = point.x - ray.origin.x, y = point.y - ray.origin.y, z = point.z - ray.origin.z;
  const glm::dvec3& d = ray.direction;
  const double cross_x = y * d.z - z * d.y;
  const double cross_y = z * d.x - x * d.z;
  const double cross_z = x * d.y - y * d.x;
  return {x * d.x + y * d.y + z * d.z, std::sqrt(cross_x * cross_x + cross_y * cross_y + cross_z * cross_z)};
}

/// Where the ray enters the sphere of `radius` around the point: t - sqrt(radius^2 - distance^2).
/// Requires distance <= radius.
inline double entry(const RayProjection& projection, double radius) {
  const double half_chord_sq = radius * radius - projection.distance * projection.distance;
  return projection.t - std::sqrt(std::max(half_chord_sq, 0.0));
}

}  // namespace alidade
