// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace alidade::image {

/// 2^stops, with equal bits on every machine (a library's pow or exp2 may differ in the last bit). For
/// |stops| <= 1000.
double exposure_scale(double stops);

/// The 8-bit sRGB code of a linear value (IEC 61966-2-1): the nearest one, 0 below black (and for NaN), 255
/// above white. Decided by comparing with the exact linear values between two codes, so it is equal on every
/// machine.
std::uint8_t srgb_code(double linear);

/// A curve over 0 .. 1 by straight lines between 65536 equal steps. Exact (to float) at codes of 8 and 16
/// bits.
class CurveTable {
 public:
  explicit CurveTable(double (*curve)(double));

  /// `value` is clamped to 0 .. 1; NaN counts as 0.
  float at(float value) const {
    constexpr float k_steps = 65535.0f;
    const float steps = value > 0.0f ? (value < 1.0f ? value * k_steps : k_steps) : 0.0f;
    const int step = static_cast<int>(steps);
    const float low = values_[static_cast<std::size_t>(step)];
    return low + (steps - static_cast<float>(step)) * (values_[static_cast<std::size_t>(step) + 1] - low);
  }

 private:
  std::vector<float> values_;
};

/// sRGB value -> linear light (IEC 61966-2-1). Error below 2e-7. The table is made at the first call.
const CurveTable& linear_from_srgb_table();
/// Linear light -> sRGB value, the inverse. Error below 5e-7.
const CurveTable& srgb_from_linear_table();

}  // namespace alidade::image
