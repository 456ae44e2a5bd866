// SPDX-License-Identifier: MIT
// Apart from compare/compared_image.cpp, since only this needs OpenImageIO's filters.
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "compare/compared_image.h"

namespace alidade::compare {
namespace {

std::vector<float> filtered(const ComparedImage& image, const std::vector<float>& values, int channels,
                            int width, int height) {
  std::vector<float> result(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                            static_cast<std::size_t>(channels));
  // OpenImageIO only reads the source, though it requests a pointer that could be written through.
  OIIO::ImageBuf source(OIIO::ImageSpec(image.width, image.height, channels, OIIO::TypeFloat),
                        const_cast<float*>(values.data()));
  OIIO::ImageBuf target(OIIO::ImageSpec(width, height, channels, OIIO::TypeFloat), result.data());
  if (!OIIO::ImageBufAlgo::resize(target, source))
    throw Error({.file = image.file.string(), .problem = "cannot resize the image: " + target.geterror()});
  return result;
}

/// The filter swings below black beside bright pixels, which tone mappers would show as white rings. Nothing
/// becomes darker than black, or than the darkest pixel where the image itself has light below 0.
void end_below(std::vector<float>& color, const std::vector<float>& source) {
  float least = 0.0f;
  for (const float value : source)
    if (std::isfinite(value)) least = std::min(least, value);
  for (float& value : color)
    if (value < least) value = least;
}

template <typename Value>
std::vector<Value> nearest(const ComparedImage& image, const std::vector<Value>& values, int components,
                           int width, int height) {
  std::vector<Value> result;
  if (values.empty()) return result;
  result.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                 static_cast<std::size_t>(components));
  for (int y = 0; y < height; ++y) {
    const std::int64_t from_y = (2 * std::int64_t{y} + 1) * image.height / (2 * std::int64_t{height});
    for (int x = 0; x < width; ++x) {
      const std::int64_t from_x = (2 * std::int64_t{x} + 1) * image.width / (2 * std::int64_t{width});
      const auto begin = values.begin() + (from_y * image.width + from_x) * components;
      result.insert(result.end(), begin, begin + components);
    }
  }
  return result;
}

}  // namespace

ComparedImage resized(const ComparedImage& image, int width, int height) {
  const auto pixels =
      static_cast<std::uint64_t>(std::max(width, 0)) * static_cast<std::uint64_t>(std::max(height, 0));
  if (width < 1 || height < 1 || pixels > k_most_compared_pixels) {
    throw Error(image.file.string(), {}, "cannot resize the image",
                "a size of 1 to " + std::to_string(k_most_compared_pixels) + " pixels",
                fmt::format("{} x {}", width, height));
  }
  ComparedImage result = in_size(image, width, height);
  if (!image.color.empty()) result.color = filtered(image, image.color, 3, width, height);
  if (!image.alpha.empty()) result.alpha = filtered(image, image.alpha, 1, width, height);
  if (image.encoding == ColorEncoding::display)
    for (float& value : result.color) value = std::clamp(value, 0.0f, 1.0f);
  else
    end_below(result.color, image.color);
  for (float& value : result.alpha) value = std::clamp(value, 0.0f, 1.0f);
  result.depth = nearest(image, image.depth, 1, width, height);
  result.depth_sigma = nearest(image, image.depth_sigma, 1, width, height);
  result.normals = nearest(image, image.normals, 3, width, height);
  result.ids = nearest(image, image.ids, 1, width, height);
  return result;
}

}  // namespace alidade::compare
