// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "base/ray.h"

namespace alidade {

/// A ray that widens: the limit on the distance to its line grows with t,
///   limit(t) = radius + slope * t,
/// which makes it a cylinder (slope 0), a cone (radius 0) or a truncated cone. Points where limit(t) < 0 are
/// outside. The paper leaves cones to future work (section 6).
struct Cone {
  Ray axis{.t_min = 0.0};  ///< from the apex; closed interval on t, by default from the apex on
  double radius = 0.0;     ///< at the apex (t = 0), metres
  double slope = 0.0;      ///< tangent of the half angle

  double limit(double t) const { return radius + slope * t; }
};

/// A cone from the outside, checked. half_angle in radians, 0 <= half_angle < pi / 2. Errors: as
/// make_ray; radius negative or not finite; half_angle out of range or so large that its tangent is not
/// finite.
Cone make_cone(const glm::dvec3& apex, const glm::dvec3& direction, double half_angle, double radius = 0.0,
               double t_min = 0.0, double t_max = std::numeric_limits<double>::infinity());

/// A plane through `point`; `normal` has length 1. Signed distance: octree/distance.h (eq. 2).
struct Plane {
  glm::dvec3 point{0.0};
  glm::dvec3 normal{0.0, 0.0, 1.0};
};

/// A plane from the outside, checked and normalised. Errors: not finite, normal of length zero.
Plane make_plane(const glm::dvec3& point, const glm::dvec3& normal);

/// The points on the positive side of every plane (signed distance >= 0): a slab (two opposite planes), a
/// view frustum (five or six), any convex region. No planes: everywhere.
struct HalfSpaces {
  std::vector<Plane> planes;
};

/// The slab of `thickness` metres on the positive side of a plane. Errors: thickness negative or not finite.
HalfSpaces make_slab(const Plane& plane, double thickness);

/// A trajectory: straight segments from vertex to vertex. Points on it are given by t, the length of the way
/// from the first vertex, in metres.
struct Path {
  std::vector<glm::dvec3> vertices;                         ///< two or more; consecutive ones differ
  std::vector<double> vertex_t;                             ///< t of every vertex, made by make_path
  double t_min = -std::numeric_limits<double>::infinity();  ///< closed interval on t
  double t_max = std::numeric_limits<double>::infinity();
};

/// A path from the outside, checked. Repeated vertices in a row are joined to one. Errors: a coordinate
/// that is not finite (the message names the vertex), fewer than two different vertices, limits NaN.
Path make_path(const std::vector<glm::dvec3>& vertices,
               double t_min = -std::numeric_limits<double>::infinity(),
               double t_max = std::numeric_limits<double>::infinity());

}  // namespace alidade
