// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

namespace alidade {

/// Part of a ray, from t = begin to t = end; empty if begin > end.
struct Stretch {
  double begin = -std::numeric_limits<double>::infinity();
  double end = std::numeric_limits<double>::infinity();

  void cut(const Stretch& other) {
    begin = std::max(begin, other.begin);
    end = std::min(end, other.end);
  }
  bool empty() const { return !(begin <= end); }
};

/// The line of a ray, for finding the part of it that lies between planes across the axes, such as those of
/// boxes.
class RaySlabs {
 public:
  RaySlabs(const glm::dvec3& origin, const glm::dvec3& direction) : origin_(origin), direction_(direction) {
    for (int axis = 0; axis < 3; ++axis) {
      // The inverse of smaller numbers would be infinite.
      is_level_[axis] = std::fabs(direction_[axis]) < 1e-290;
      inverse_[axis] = is_level_[axis] ? 0.0 : 1.0 / direction_[axis];
    }
  }

  const glm::dvec3& origin() const { return origin_; }
  const glm::dvec3& direction() const { return direction_; }

  /// The part between two values of one coordinate. Monotonic, including rounding: the part between values
  /// within these lies within. So what is skipped with a box around it would also have been skipped by
  /// itself.
  Stretch between(int axis, double low, double high) const {
    constexpr double k_infinity = std::numeric_limits<double>::infinity();
    const double to_low = low - origin_[axis], to_high = high - origin_[axis];
    if (is_level_[axis]) return to_low > 0.0 || to_high < 0.0 ? Stretch{k_infinity, -k_infinity} : Stretch{};
    const double a = to_low * inverse_[axis], b = to_high * inverse_[axis];
    return {std::min(a, b), std::max(a, b)};
  }

 private:
  glm::dvec3 origin_, direction_, inverse_{0.0};
  std::array<bool, 3> is_level_{};
};

}  // namespace alidade
