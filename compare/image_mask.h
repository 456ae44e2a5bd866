// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "compare/compared_image.h"

namespace alidade::compare {

/// Which pixels count.
struct ImageMask {
  std::vector<std::uint8_t> counts;  ///< one per pixel, 1 counts, 0 does not; empty: all do

  bool at(std::size_t pixel) const { return counts.empty() || counts[pixel] != 0; }
};

/// Number of pixels that count in a picture of so many.
std::uint64_t counted_pixels(const ImageMask& mask, std::size_t pixels);

// Each of these takes pixels out of `mask`; several in a row leave what all of them leave. "Every picture
// that has it" are those of the two that have the layer in question. Errors name what is missing.

/// Leaves the pixels that are light in a mask image: above half of the display range in the mean of its
/// channels. Errors: another width or height than `image` (SizeMismatch), whatever reading gives, an image
/// without colour.
void keep_light(ImageMask& mask, const ComparedImage& mask_image, const ComparedImage& image);

/// Leaves pixels with alpha >= `least` in every picture that has it. Errors: none of them has alpha.
void keep_alpha(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test,
                float least = 0.5f);

/// Leaves pixels whose depth is finite and above 0 in every picture that has it. Errors: none has depth.
void keep_valid_depth(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test);

/// Takes out pixels that are sky (id 0; without ids: no depth) in every picture that has it: where one
/// sees a surface and the other the sky something changed, and it stays. Errors: none has ids or depth.
void ignore_sky(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test);

/// Leaves the pixels inside any of the rectangles, which may reach beyond the picture. None: all stay.
void keep_rectangles(ImageMask& mask, const ComparedImage& image, std::span<const PixelRectangle> rectangles);
/// Takes out the pixels inside any of them.
void ignore_rectangles(ImageMask& mask, const ComparedImage& image,
                       std::span<const PixelRectangle> rectangles);

/// Takes out pixels with a NaN or infinite colour value in either picture; returns how many it took out.
/// The metrics do the same for themselves.
std::uint64_t keep_finite(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test);

}  // namespace alidade::compare
