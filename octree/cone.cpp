// SPDX-License-Identifier: MIT
#include "octree/cone.h"

#include <fmt/format.h>

namespace alidade {

Cone make_cone(const glm::dvec3& apex, const glm::dvec3& direction, double half_angle, double radius,
               double t_min, double t_max) {
  constexpr double k_right_angle = 1.5707963267948966;
  if (!(half_angle >= 0.0 && half_angle < k_right_angle)) {
    throw Error({.problem = "half angle of a cone is out of range",
                 .expected = "at least 0 and less than pi / 2",
                 .found = fmt::format("{}", half_angle)});
  }
  if (!(radius >= 0.0 && std::isfinite(radius))) {
    throw Error({.problem = "radius of a cone is out of range",
                 .expected = "a finite number, at least 0",
                 .found = fmt::format("{}", radius)});
  }
  return {make_ray(apex, direction, t_min, t_max), radius, std::tan(half_angle)};
}

}  // namespace alidade
