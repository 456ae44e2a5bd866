// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "compare/compared_image.h"
#include "compare/image_mask.h"
#include "image/srgb.h"

namespace alidade {

/// The colours of two pictures as filters read them. Where a pixel does not count, or is not finite in one of
/// them, both give the same colour (the reference's if it is finite, else the test's, else black): what does
/// not count makes no difference to its neighbours either.
class PairPixels {
 public:
  /// The pictures must be of equal size, have colour, and outlive this; so must the mask.
  PairPixels(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask,
             ColorEncoding encoding)
      : mask_(mask),
        colors_{reference.color.data(), test.color.data()},
        curves_{curve(reference, encoding), curve(test, encoding)} {}

  struct Pair {
    float color[2][3];  ///< reference, test
  };

  Pair at(std::size_t pixel) const {
    const float* from[2] = {colors_[0] + 3 * pixel, colors_[1] + 3 * pixel};
    const bool is_finite[2] = {finite(from[0]), finite(from[1])};
    if (!mask_.at(pixel) || !is_finite[0] || !is_finite[1]) {
      if (!is_finite[0] && !is_finite[1]) return {};
      Pair same;
      const int kept = is_finite[0] ? 0 : 1;
      for (int i = 0; i < 3; ++i) same.color[0][i] = same.color[1][i] = converted(kept, from[kept][i]);
      return same;
    }
    Pair pair;
    for (int picture = 0; picture < 2; ++picture)
      for (int i = 0; i < 3; ++i) pair.color[picture][i] = converted(picture, from[picture][i]);
    return pair;
  }

 private:
  static const CurveTable* curve(const ComparedImage& image, ColorEncoding encoding) {
    if (image.encoding == encoding) return nullptr;
    return encoding == ColorEncoding::linear ? &linear_from_srgb_table() : &srgb_from_linear_table();
  }
  static bool finite(const float* color) {
    return std::isfinite(color[0]) && std::isfinite(color[1]) && std::isfinite(color[2]);
  }
  float converted(int picture, float value) const {
    return curves_[picture] ? curves_[picture]->at(value) : value;
  }

  const ImageMask& mask_;
  const float* colors_[2];
  const CurveTable* curves_[2];
};

}  // namespace alidade
