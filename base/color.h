// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include "base/exact_math.h"

namespace alidade {

/// Colours in scene structs and in the tracer are linear Rec. 709, per channel; albedos lie in [0, 1].
using Rgb = glm::vec3;

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
