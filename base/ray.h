// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

#include "base/error.h"
#include "base/unit_direction.h"

namespace alidade {

/// A line through the world with a place on it: position(t) = origin + t * direction.
/// `direction` has length 1, so t is in metres. Queries look at points whose projection falls into the closed
/// interval [t_min, t_max]; by default that is all of the line, in both directions, as in the paper (section
/// 2).
struct Ray {
  glm::dvec3 origin{0.0};
  glm::dvec3 direction{0.0, 0.0, 1.0};
  double t_min = -std::numeric_limits<double>::infinity();
  double t_max = std::numeric_limits<double>::infinity();

  glm::dvec3 position(double t) const { return origin + t * direction; }
};

/// The entrance for rays from outside: normalises the direction. Errors: direction zero or not finite, origin
/// not finite, limits NaN. An interval with t_min > t_max is allowed and holds nothing.
inline Ray make_ray(const glm::dvec3& origin, const glm::dvec3& direction,
                    double t_min = -std::numeric_limits<double>::infinity(),
                    double t_max = std::numeric_limits<double>::infinity()) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(origin[axis])) throw Error({.problem = "ray origin is not finite"});
    if (!std::isfinite(direction[axis])) throw Error({.problem = "ray direction is not finite"});
  }
  if (std::isnan(t_min) || std::isnan(t_max))
    throw Error({.problem = "limit of the ray's interval is not a number"});
  if (direction == glm::dvec3(0.0)) throw Error({.problem = "ray direction has length zero"});
  return {origin, unit_direction(direction), t_min, t_max};
}

}  // namespace alidade
