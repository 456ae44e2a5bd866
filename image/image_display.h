// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace alidade {

/// 2^stops, the same bits on every machine (a library's pow or exp2 may differ in the last bit). For |stops|
/// <= 1000.
double exposure_scale(double stops);

/// The 8-bit sRGB code of a linear value (IEC 61966-2-1): the nearest one, 0 below black (and for NaN), 255
/// above white. Decided by comparing with the exact linear values between two codes, so it is the same on
/// every machine.
std::uint8_t srgb_code(double linear);

}  // namespace alidade
