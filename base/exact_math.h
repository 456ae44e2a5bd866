// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>

#include "base/sine_cosine.h"

// The few curves the tracer needs, from operations that IEEE 754 rounds exactly (+ - * / sqrt). The functions
// of the C library differ in their last bits from machine to machine, and one such bit can turn a path: image
// bytes would differ.

namespace alidade {

/// Angle of the vector (x, y) against the x axis, in (-pi, pi]; 0 for the zero vector. Error below 5e-16, and
/// relative to the result if x > 0. Source: Taylor series around the nearest eighth of the smaller
/// coordinate over the larger, atan a = atan c + atan((a - c) / (1 + a c)).
inline double angle_of(double y, double x) {
  constexpr double k_eighths[] = {0.0,
                                  0.12435499454676144,
                                  0.24497866312686414,
                                  0.35877067027057225,
                                  0.46364760900080609,
                                  0.55859931534356244,
                                  0.64350110879328437,
                                  0.71882999962162453,
                                  0.78539816339744828};
  const double across = std::fabs(y), along = std::fabs(x);
  const double larger = std::fmax(across, along), smaller = std::fmin(across, along);
  if (larger == 0.0) return 0.0;
  const double ratio = smaller / larger;
  const double eighth = std::floor(8.0 * ratio + 0.5), center = 0.125 * eighth;
  const double z = (ratio - center) / (1.0 + ratio * center), z2 = z * z;
  double series = 0.0;
  for (int n = 15; n >= 3; n -= 2) series = z2 * (1.0 / n - series);
  double angle = k_eighths[static_cast<int>(eighth)] + (z - z * series);
  if (across > along) angle = 0.5 * std::numbers::pi - angle;
  if (x < 0.0) angle = std::numbers::pi - angle;
  return y < 0.0 ? -angle : angle;
}

/// The `degree`-th root of x in [0, 1], by Newton's method from above. Relative error below 1e-15.
inline double root(double x, int degree) {
  if (x <= 0.0) return 0.0;
  double guess = 1.0;
  for (;;) {
    double power = 1.0;
    for (int i = 1; i < degree; ++i) power *= guess;
    const double next = guess + (x / power - guess) / degree;
    // From above the sequence falls until rounding stops it.
    if (!(next < guess)) return guess;
    guess = next;
  }
}

/// Display-referred value in [0, 1] -> linear, by the curve of IEC 61966-2-1 (sRGB).
inline double linear_from_srgb(double value) {
  if (value <= 0.04045) return value / 12.92;
  const double base = (value + 0.055) / 1.055;
  const double fifth_root = root(base, 5);
  return base * base * fifth_root * fifth_root;  // base^2.4
}

/// Linear value in [0, 1] -> display-referred, the inverse of the above.
inline double srgb_from_linear(double value) {
  if (value <= 0.0031308) return value * 12.92;
  const double twelfth_root = root(value, 12);
  const double sq = twelfth_root * twelfth_root;
  return 1.055 * (sq * sq * twelfth_root) - 0.055;  // value^(5/12)
}

}  // namespace alidade
