// SPDX-License-Identifier: MIT
#include "octree/targets.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "base/unit_direction.h"

namespace alidade {

Plane make_plane(const glm::dvec3& point, const glm::dvec3& normal) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(point[axis])) throw Error({.problem = "point of a plane is not finite"});
    if (!std::isfinite(normal[axis])) throw Error({.problem = "normal of a plane is not finite"});
  }
  if (normal == glm::dvec3(0.0)) throw Error({.problem = "normal of a plane has length zero"});
  return {point, unit_direction(normal)};
}

HalfSpaces make_slab(const Plane& plane, double thickness) {
  if (!(thickness >= 0.0 && std::isfinite(thickness))) {
    throw Error({.problem = "thickness of a slab is out of range",
                 .expected = "a finite number, at least 0",
                 .found = fmt::format("{}", thickness)});
  }
  return {{plane, {plane.point + thickness * plane.normal, -plane.normal}}};
}

}  // namespace alidade
