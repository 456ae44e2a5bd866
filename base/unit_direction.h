// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/vec3.hpp>

namespace alidade {

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

}  // namespace alidade
