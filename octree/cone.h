// SPDX-License-Identifier: MIT
#pragma once

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

/// The entrance for cones from outside. half_angle in radians, 0 <= half_angle < pi / 2. Errors: as
/// make_ray; radius negative or not finite; half_angle out of range or so large that its tangent is not
/// finite.
Cone make_cone(const glm::dvec3& apex, const glm::dvec3& direction, double half_angle, double radius = 0.0,
               double t_min = 0.0, double t_max = std::numeric_limits<double>::infinity());

}  // namespace alidade
