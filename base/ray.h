// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

#include "base/error.h"

namespace alidade {

/// Whether all coordinates are.
inline bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Length of a vector. Scaled by the largest component first, so that neither tiny nor huge vectors under- or
/// overflow.
inline double length_of(const glm::dvec3& v) {
  const double largest = std::fmax(std::fabs(v.x), std::fmax(std::fabs(v.y), std::fabs(v.z)));
  if (largest == 0.0) return 0.0;
  const glm::dvec3 scaled = v / largest;
  return largest * std::sqrt(scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z);
}

/// The vector with length 1, whatever its length was. Requires: finite and not zero.
inline glm::dvec3 unit_direction(const glm::dvec3& v) {
  const double largest = std::fmax(std::fabs(v.x), std::fmax(std::fabs(v.y), std::fabs(v.z)));
  const glm::dvec3 scaled = v / largest;
  return scaled / std::sqrt(scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z);
}

/// A line through the world with an origin on it: position(t) = origin + t * direction.
/// `direction` has length 1, so t is in metres. Queries test the points whose projection falls into the
/// closed interval [t_min, t_max]; by default that is all of the line, in both directions, as in the paper
/// (section 2).
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
    if (!std::isfinite(origin[axis])) throw Error({.problem = "the ray origin is not finite"});
    if (!std::isfinite(direction[axis])) throw Error({.problem = "the ray direction is not finite"});
  }
  if (std::isnan(t_min) || std::isnan(t_max))
    throw Error({.problem = "a limit of the ray's interval is NaN"});
  if (direction == glm::dvec3(0.0)) throw Error({.problem = "the ray direction is zero"});
  return {origin, unit_direction(direction), t_min, t_max};
}

}  // namespace alidade
