// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace alidade::simd {

/// A float that is not below a number, nor above it by more than its rounding; of numbers beyond 1e30,
/// infinite ones too, those of 1e30: squares of such floats are no numbers, so nothing is told by being
/// above.
inline float at_least(double value) {
  const auto f = static_cast<float>(std::clamp(value, -1e30, 1e30));
  return f + std::fabs(f) * 0x1p-23f + std::numeric_limits<float>::min();
}

inline float at_most(double value) {
  return -at_least(-value);
}

}  // namespace alidade::simd
