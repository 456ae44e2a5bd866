// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

#include "base/bounds.h"

// Formulas on intervals instead of numbers: their results hold those of every point of a box.
//
// Rounding to nearest never changes an order: a <= b gives round(a op c) <= round(b op c). So when a formula
// is computed on the ends of intervals with the same operations in the same order as for one point, the
// interval holds the value *as computed* for every point, to the last bit. Bounds made this way need no
// allowance for rounding: not for coordinates of 10^7 m, not for directions along an axis or with components
// of 10^-200, not for underflow. Where a number overflows, an end may become NaN; every test here and in
// tree_query.h is written so that NaN discards nothing.

namespace alidade {

struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

inline Interval operator+(const Interval& a, const Interval& b) {
  return {a.low + b.low, a.high + b.high};
}

inline Interval operator-(const Interval& a, const Interval& b) {
  return {a.low - b.high, a.high - b.low};
}

inline Interval operator*(const Interval& a, double factor) {
  // The near and far corners of eq. 4: which end counts is the sign of the direction's component.
  if (factor < 0.0) return {a.high * factor, a.low * factor};
  return {a.low * factor, a.high * factor};
}

/// Smallest |x|.
inline double least_magnitude(const Interval& x) {
  return std::max({0.0, x.low, -x.high});
}

/// Largest |x|. NaN if an end is.
inline double greatest_magnitude(const Interval& x) {
  return !(-x.low <= x.high) && !std::isnan(x.high) ? -x.low : x.high;
}

/// A box relative to a point: per axis, its coordinates minus that of `from`.
inline std::array<Interval, 3> relative(const Bounds& box, const glm::dvec3& from) {
  return {Interval{box.min.x - from.x, box.max.x - from.x}, Interval{box.min.y - from.y, box.max.y - from.y},
          Interval{box.min.z - from.z, box.max.z - from.z}};
}

}  // namespace alidade
