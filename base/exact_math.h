// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

// Sine and cosine from operations that IEEE 754 rounds exactly (+ - * / sqrt): those of the C library differ
// in their last bits from machine to machine.

namespace alidade {

struct SineCosine {
  double sine = 0.0;
  double cosine = 1.0;
};

/// Sine and cosine of an angle that is larger by 0 to 3 quarter turns.
inline SineCosine turned_by_quarters(const SineCosine& of, int quarters) {
  switch (quarters) {
    case 0:
      return of;
    case 1:
      return {of.cosine, -of.sine};
    case 2:
      return {-of.sine, -of.cosine};
    default:
      return {-of.cosine, of.sine};
  }
}

/// sin and cos of 2 pi `turns`, for |turns| < 2^30. Error below 4e-16. Source: Taylor series around the
/// nearest quarter turn.
inline SineCosine sine_cosine_of_turns(double turns) {
  const double quarter = std::floor(4.0 * turns + 0.5);
  const double x = (turns - 0.25 * quarter) * (2.0 * std::numbers::pi);
  const double x2 = x * x;
  double sine = 0.0, cosine = 0.0;
  // Horner's scheme: 1 - x2/(2*3) (1 - x2/(4*5) (...)), and the same for the cosine; terms up to x^17 and
  // x^18.
  for (int n = 16; n >= 2; n -= 2) {
    sine = -(1.0 + sine) * (x2 / (n * (n + 1)));
    cosine = -(1.0 + cosine) * (x2 / ((n + 1) * (n + 2)));
  }
  sine = (1.0 + sine) * x;
  cosine = 1.0 - (1.0 + cosine) * (0.5 * x2);
  return turned_by_quarters({sine, cosine}, static_cast<int>(quarter - 4.0 * std::floor(0.25 * quarter)));
}

/// sin and cos of an angle in degrees.
inline SineCosine sine_cosine_of_degrees(double degrees) {
  return sine_cosine_of_turns(degrees / 360.0);
}

/// sin and cos of an angle in radians, for |angle| < 2^30. Error below 4e-16 for |angle| <= pi.
inline SineCosine sine_cosine(double radians) {
  return sine_cosine_of_turns(radians / (2.0 * std::numbers::pi));
}

// Sine and cosine from multiplications and additions alone. The standard library's may differ in the last bit
// from machine to machine; these cannot, as long as contraction is off, so scans have equal bytes everywhere.

/// Sine and cosine of an angle in radians, |angle| <= 1e5; absolute error below 1e-15 up to |angle| = 100.
/// Method: subtract the nearest multiple of pi/2 in two parts (Cody and Waite), then the Taylor series on
/// [-pi/4, pi/4], whose first omitted terms are below 5e-17.
inline SineCosine sine_cosine_by_quarters(double angle) {
  constexpr double k_high = 1.57079632673412561417;     // the first 33 bits of pi/2: multiples stay exact
  constexpr double k_low = 6.07710050650619224932e-11;  // the rest
  const double quarter_turns = std::floor(angle * (2.0 / std::numbers::pi) + 0.5);
  const double x = (angle - quarter_turns * k_high) - quarter_turns * k_low;
  const double y = x * x;
  const double sine =
      x + x * y *
              (-1.0 / 6 +
               y * (1.0 / 120 +
                    y * (-1.0 / 5040 +
                         y * (1.0 / 362880 + y * (-1.0 / 39916800 + y * (1.0 / 6227020800.0 +
                                                                         y * (-1.0 / 1307674368000.0)))))));
  const double cosine =
      1.0 + y * (-1.0 / 2 +
                 y * (1.0 / 24 +
                      y * (-1.0 / 720 + y * (1.0 / 40320 + y * (-1.0 / 3628800 +
                                                                y * (1.0 / 479001600.0 +
                                                                     y * (-1.0 / 87178291200.0 +
                                                                          y * (1.0 / 20922789888000.0))))))));
  return turned_by_quarters({sine, cosine}, static_cast<int>(static_cast<std::int64_t>(quarter_turns) & 3));
}

// The few curves the tracer needs, from operations that IEEE 754 rounds exactly (+ - * / sqrt). The functions
// of the C library differ in their last bits from machine to machine, and one such bit can turn a path: image
// bytes would differ.

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

// From operations that IEEE 754 rounds exactly as well, so that filters and exposures have equal bits on
// every machine.

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
