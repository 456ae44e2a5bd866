// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>

// As in base/exact_math.h: from operations that IEEE 754 rounds exactly, so that filters and
// exposures are the same bits on every machine.

namespace alidade {

/// e^x for x in [-700, 0]. Relative error below 1e-12. Source: Taylor series of x / 1024, squared ten times.
inline double exponential(double x) {
  const double part = x / 1024.0;
  double sum = 1.0;
  for (int n = 20; n >= 1; --n) sum = 1.0 + sum * part / n;
  for (int i = 0; i < 10; ++i) sum *= sum;
  return sum;
}

/// log2 x for finite x > 0. Error below 1e-15 of the larger of 1 and the result. Source: the series
/// ln m = 2 (s + s^3 / 3 + s^5 / 5 ...) with s = (m - 1) / (m + 1), m the mantissa in [sqrt 1/2, sqrt 2).
inline double binary_logarithm(double x) {
  int exponent = 0;
  double mantissa = std::frexp(x, &exponent);
  if (mantissa < 0.5 * std::numbers::sqrt2) {
    mantissa *= 2.0;
    --exponent;
  }
  const double s = (mantissa - 1.0) / (mantissa + 1.0), s2 = s * s;
  double sum = 0.0;
  for (int n = 25; n >= 1; n -= 2) sum = sum * s2 + 1.0 / n;
  return exponent + 2.0 * std::numbers::log2e * s * sum;
}

}  // namespace alidade
