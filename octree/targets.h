// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <vector>

namespace alidade {

/// A plane through `point`; `normal` has length 1. Signed distance: octree/distance.h (eq. 2).
struct Plane {
  glm::dvec3 point{0.0};
  glm::dvec3 normal{0.0, 0.0, 1.0};
};

/// The entrance for planes from outside: normalises. Errors: not finite, normal of length zero.
Plane make_plane(const glm::dvec3& point, const glm::dvec3& normal);

/// The points on the positive side of every plane (signed distance >= 0): a slab (two opposite planes), a
/// view frustum (five or six), any convex region. No planes: everywhere.
struct HalfSpaces {
  std::vector<Plane> planes;
};

/// The slab of `thickness` metres on the positive side of a plane. Errors: thickness negative or not finite.
HalfSpaces make_slab(const Plane& plane, double thickness);

}  // namespace alidade
