// SPDX-License-Identifier: MIT
#include "compare/compared_image.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

std::string text_of(const ComparedImage& image) {
  std::string text = std::to_string(image.width) + " x " + std::to_string(image.height);
  if (image.origin_x != 0 || image.origin_y != 0)
    text += " at " + std::to_string(image.origin_x) + "," + std::to_string(image.origin_y);
  return text;
}

std::vector<float> through(const image::CurveTable& curve, const std::vector<float>& values) {
  std::vector<float> result(values.size());
  in_parallel(values.size(), 65536, [&](std::size_t i) { result[i] = curve.at(values[i]); });
  return result;
}

template <typename Value>
std::vector<Value> part(const std::vector<Value>& values, int width, const PixelRectangle& rectangle,
                        int components) {
  std::vector<Value> result;
  if (values.empty()) return result;
  const auto columns = static_cast<std::ptrdiff_t>(rectangle.right - rectangle.left) * components;
  result.reserve(static_cast<std::size_t>(columns) *
                 static_cast<std::size_t>(rectangle.bottom - rectangle.top));
  for (int y = rectangle.top; y < rectangle.bottom; ++y) {
    const auto begin =
        values.begin() + (static_cast<std::ptrdiff_t>(y) * width + rectangle.left) * components;
    result.insert(result.end(), begin, begin + columns);
  }
  return result;
}

}  // namespace

std::vector<float> linear_color(const ComparedImage& image) {
  return image.encoding == ColorEncoding::linear ? image.color
                                                 : through(image::linear_from_srgb_table(), image.color);
}

std::vector<float> display_color(const ComparedImage& image) {
  return image.encoding == ColorEncoding::display ? image.color
                                                  : through(image::srgb_from_linear_table(), image.color);
}

bool is_depth(float depth) {
  return std::isfinite(depth) && depth > 0.0f;
}

bool shows_surface(const ComparedImage& image, std::size_t pixel) {
  return (image.alpha.empty() || image.alpha[pixel] >= 0.5f) &&
         (image.depth.empty() || is_depth(image.depth[pixel]));
}

void require_same_size(const ComparedImage& reference, const ComparedImage& test) {
  if (reference.width == test.width && reference.height == test.height &&
      reference.origin_x == test.origin_x && reference.origin_y == test.origin_y)
    return;
  throw SizeMismatch({.file = test.file.string(),
                      .problem = "the size differs from the reference " + reference.file.string(),
                      .expected = text_of(reference),
                      .found = text_of(test)});
}

void require_colors(const ComparedImage& reference, const ComparedImage& test, const char* problem) {
  require_same_size(reference, test);
  for (const ComparedImage* const image : {&reference, &test})
    if (image->color_channels == 0)
      throw Error({.file = image->file.string(), .problem = problem, .expected = "channels R G B"});
}

ComparedImage cropped(const ComparedImage& image, const PixelRectangle& rectangle) {
  const bool is_inside = rectangle.left >= 0 && rectangle.top >= 0 && rectangle.right <= image.width &&
                         rectangle.bottom <= image.height;
  if (!is_inside || rectangle.left >= rectangle.right || rectangle.top >= rectangle.bottom) {
    throw Error({.file = image.file.string(),
                 .problem = "the crop is empty or exceeds the image",
                 .expected = "a rectangle inside " + text_of(image),
                 .found = "columns " + std::to_string(rectangle.left) + " to " +
                          std::to_string(rectangle.right) + ", rows " + std::to_string(rectangle.top) +
                          " to " + std::to_string(rectangle.bottom)});
  }
  ComparedImage result;
  result.file = image.file;
  result.width = rectangle.right - rectangle.left;
  result.height = rectangle.bottom - rectangle.top;
  result.origin_x = image.origin_x + rectangle.left;
  result.origin_y = image.origin_y + rectangle.top;
  result.encoding = image.encoding;
  result.color_channels = image.color_channels;
  result.largest_code = image.largest_code;
  result.color = part(image.color, image.width, rectangle, 3);
  result.alpha = part(image.alpha, image.width, rectangle, 1);
  result.depth = part(image.depth, image.width, rectangle, 1);
  result.normals = part(image.normals, image.width, rectangle, 3);
  result.ids = part(image.ids, image.width, rectangle, 1);
  result.metadata = image.metadata;
  return result;
}

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
/// becomes darker than black, or than the darkest pixel where the picture itself has light below 0.
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
    throw Error({.file = image.file.string(),
                 .problem = "cannot resize the image",
                 .expected = "a size of 1 to " + std::to_string(k_most_compared_pixels) + " pixels",
                 .found = std::to_string(width) + " x " + std::to_string(height)});
  }
  ComparedImage result;
  result.file = image.file;
  result.width = width;
  result.height = height;
  result.encoding = image.encoding;
  result.color_channels = image.color_channels;
  result.metadata = image.metadata;
  if (!image.color.empty()) result.color = filtered(image, image.color, 3, width, height);
  if (!image.alpha.empty()) result.alpha = filtered(image, image.alpha, 1, width, height);
  if (image.encoding == ColorEncoding::display)
    for (float& value : result.color) value = std::clamp(value, 0.0f, 1.0f);
  else
    end_below(result.color, image.color);
  for (float& value : result.alpha) value = std::clamp(value, 0.0f, 1.0f);
  result.depth = nearest(image, image.depth, 1, width, height);
  result.normals = nearest(image, image.normals, 3, width, height);
  result.ids = nearest(image, image.ids, 1, width, height);
  return result;
}

}  // namespace alidade::compare
