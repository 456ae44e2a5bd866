// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>

// Sine and cosine from multiplications and additions alone. The standard library's may differ in the last bit
// from machine to machine; these cannot, as long as contraction is off, so scans are the same bytes
// everywhere.

namespace alidade {

inline constexpr double k_pi = 3.14159265358979323846;

inline constexpr double radians(double degrees) {
  return degrees * (k_pi / 180.0);
}

struct SineCosine {
  double sine = 0.0, cosine = 1.0;
};

/// Of an angle in radians, |angle| <= 1e5; absolute error below 1e-15 up to |angle| = 100.
/// Method: subtract the nearest multiple of pi/2 in two parts (Cody and Waite), then the Taylor series on
/// [-pi/4, pi/4], whose first omitted terms are below 5e-17.
inline SineCosine sine_cosine(double angle) {
  constexpr double k_high = 1.57079632673412561417;     // the first 33 bits of pi/2: multiples stay exact
  constexpr double k_low = 6.07710050650619224932e-11;  // the rest
  const double quarter_turns = std::floor(angle * (2.0 / k_pi) + 0.5);
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
  switch (static_cast<std::int64_t>(quarter_turns) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

}  // namespace alidade
