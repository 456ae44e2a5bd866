// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "compare/compared_image.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace compare;

/// An image of one colour.
inline ComparedImage uniform_image(int width, int height, ColorEncoding encoding, float red, float green,
                                   float blue) {
  ComparedImage image;
  image.file = "uniform";
  image.width = width;
  image.height = height;
  image.encoding = encoding;
  image.color_channels = 3;
  for (std::size_t i = 0; i < image.pixels(); ++i) image.color.insert(image.color.end(), {red, green, blue});
  return image;
}

/// Soft patches of colour with grain: codes of 8 bits, or light from 0 to 8 with some below 0.
inline ComparedImage patchy_image(int width, int height, ColorEncoding encoding, const std::string& seed,
                                  double grain = 0.1) {
  Random random(seed);
  ComparedImage image = uniform_image(width, height, encoding, 0.0f, 0.0f, 0.0f);
  image.largest_code = encoding == ColorEncoding::display ? 255 : 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int i = 0; i < 3; ++i) {
        const double ground =
            0.5 + 0.3 * std::sin(0.21 * x + i) * std::cos(0.17 * y - i) + (x / 9 % 2 ? 0.1 : -0.1);
        const double value = std::clamp(ground + grain * (random.unit() - 0.5), 0.0, 1.0);
        image.color[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(x)) +
                    static_cast<std::size_t>(i)] =
            static_cast<float>(encoding == ColorEncoding::display ? std::floor(255.0 * value + 0.5) / 255.0
                                                                  : 8.0 * value * value * value - 0.02);
      }
    }
  }
  return image;
}

}  // namespace alidade::test
