// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
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

/// An image of so many pixels with the values of `color(x, y)`, three numbers each.
template <typename Color>
ComparedImage draw_image(int width, int height, ColorEncoding encoding, const Color& color) {
  ComparedImage image;
  image.file = "drawn.png";
  image.width = width;
  image.height = height;
  image.encoding = encoding;
  image.color_channels = 3;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const double value : std::array<double, 3>(color(x, y)))
        image.color.push_back(static_cast<float>(value));
    }
  }
  return image;
}

/// A number in [0, 1) for each of a counter's values.
inline double hashed(std::uint64_t counter) {
  std::uint64_t z = (counter + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

/// Smooth blots of all sizes, without a period, in [0, 1].
inline double blots(double x, double y, std::uint64_t seed = 0) {
  double sum = 0.0, weight = 0.0;
  std::uint64_t octave = seed;
  for (double size = 64.0; size >= 4.0; size /= 2.0, ++octave) {
    const auto lattice = [&](double i, double j) {
      return hashed(octave * 1000003u +
                    static_cast<std::uint64_t>(static_cast<std::int64_t>(i) + 100000) * 200003u +
                    static_cast<std::uint64_t>(static_cast<std::int64_t>(j) + 100000));
    };
    const double i = std::floor(x / size), j = std::floor(y / size);
    const auto ease = [](double t) { return t * t * (3.0 - 2.0 * t); };
    const double u = ease(x / size - i), v = ease(y / size - j);
    const double value = (lattice(i, j) * (1.0 - u) + lattice(i + 1, j) * u) * (1.0 - v) +
                         (lattice(i, j + 1) * (1.0 - u) + lattice(i + 1, j + 1) * u) * v;
    sum += size * value;
    weight += size;
  }
  return sum / weight;
}

}  // namespace alidade::test
