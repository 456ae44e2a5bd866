// SPDX-License-Identifier: MIT
#include "compare/displayed_picture.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "image/srgb.h"

namespace alidade {
namespace {

std::uint8_t code(float value) {
  return static_cast<std::uint8_t>(std::lround(255.0f * (value > 0.0f ? std::min(value, 1.0f) : 0.0f)));
}

/// Calls value(pixel, channel), which answers sRGB in 0 .. 1.
template <typename Value>
BytePicture picture_of(const ComparedImage& image, const Value& value) {
  BytePicture picture{image.width, image.height, std::vector<std::uint8_t>(3 * image.pixels())};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, image.pixels(), 1 << 16), [&](const auto& range) {
    for (std::size_t pixel = range.begin(); pixel < range.end(); ++pixel)
      for (std::size_t c = 0; c < 3; ++c) picture.bytes[3 * pixel + c] = code(value(pixel, c));
  });
  return picture;
}

}  // namespace

BytePicture displayed(const ComparedImage& image, double farthest) {
  if (!image.color.empty()) {
    if (image.encoding == ColorEncoding::display)
      return picture_of(image, [&](std::size_t pixel, std::size_t c) { return image.color[3 * pixel + c]; });
    const CurveTable& curve = srgb_from_linear_table();
    return picture_of(image,
                      [&](std::size_t pixel, std::size_t c) { return curve.at(image.color[3 * pixel + c]); });
  }
  if (!image.normals.empty())
    return picture_of(
        image, [&](std::size_t pixel, std::size_t c) { return 0.5f + 0.5f * image.normals[3 * pixel + c]; });
  if (!image.depth.empty()) {
    const float scale = farthest > 0.0 ? static_cast<float>(1.0 / farthest) : 0.0f;
    return picture_of(image,
                      [&](std::size_t pixel, std::size_t) { return 1.0f - image.depth[pixel] * scale; });
  }
  return picture_of(image, [&](std::size_t pixel, std::size_t c) {
    // Knuth's multiplicative hash spreads neighbouring ids over the colours.
    const std::uint32_t hash = image.ids[pixel] * 2654435761u;
    return image.ids[pixel] == 0 ? 0.0f : static_cast<float>(hash >> (8 * c) & 255u) / 255.0f;
  });
}

double farthest_depth(const ComparedImage& image) {
  float farthest = 0.0f;
  for (const float depth : image.depth)
    if (std::isfinite(depth)) farthest = std::max(farthest, depth);
  return farthest;
}

}  // namespace alidade
