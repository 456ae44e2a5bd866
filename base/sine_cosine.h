// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>

// Sine and cosine from operations that IEEE 754 rounds exactly (+ - * / sqrt): those of the C library differ
// in their last bits from machine to machine.

namespace alidade {

struct SineCosine {
  double sine = 0.0;
  double cosine = 1.0;
};

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
  switch (static_cast<int>(quarter - 4.0 * std::floor(0.25 * quarter))) {
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

/// sin and cos of an angle in degrees.
inline SineCosine sine_cosine_of_degrees(double degrees) {
  return sine_cosine_of_turns(degrees / 360.0);
}

/// sin and cos of an angle in radians, for |angle| < 2^30. Error below 4e-16 for |angle| <= pi.
inline SineCosine sine_cosine(double radians) {
  return sine_cosine_of_turns(radians / (2.0 * std::numbers::pi));
}

}  // namespace alidade
