// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "compare/compared_image.h"

namespace alidade::compare {

/// Gradients of an image at one resolution, in steps of 1/127: g / sqrt(|g|^2 + s^2), s the root mean square
/// of |g| over the pixels that count. Whole numbers, so that sums over them are exact in any order.
struct GradientLevel {
  int width = 0, height = 0;
  std::vector<std::int8_t> x{}, y{};   ///< 0 where the pixel does not count
  std::vector<std::uint8_t> counts{};  ///< 1 or 0
  std::uint64_t counted_pixels = 0;
};

/// Gradients of the luminance of the display-referred colours; level 0 has the image's size, each further
/// one half of it, rounded up. A pixel (x, y) of a level is at (2 x, 2 y) of the one before. What counts:
/// compare/photographs/alignment.h. Pixels whose neighbours count for more than half in the binomial filter
/// count as well, so that single holes close. Requires levels >= 1. Memory: 8 bytes per pixel beside the
/// result, which takes 4.
std::vector<GradientLevel> gradient_pyramid(const ComparedImage& image, const ImageMask& mask, int levels);

}  // namespace alidade::compare
