// SPDX-License-Identifier: MIT
#include "compare/compared_image.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <algorithm>
#include <functional>

#include "base/parallel.h"
#include "image/read_image.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

std::string text_of(const ComparedImage& image) {
  std::string text = image::size_text({image.width, image.height});
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
std::vector<Value> part(const std::vector<Value>& values, int width, const image::PixelBox& rectangle,
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

/// Leaves the pixels for which `stays(pixel)` is true.
template <typename Stays>
void keep(ImageMask& mask, std::size_t pixels, const Stays& stays) {
  if (mask.counts.empty()) mask.counts.assign(pixels, 1);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    if (mask.counts[pixel] != 0 && !stays(pixel)) mask.counts[pixel] = 0;
}

[[noreturn]] void fail_layer(const std::string& wish, const std::string& layer,
                             const ComparedImage& reference, const ComparedImage& test) {
  throw Error({.problem = wish + ", but neither image has the layer",
               .expected = layer + " in " + reference.file.string() + " or " + test.file.string()});
}

bool has_color(const ComparedImage& image) {
  return image.color_channels > 0;
}

bool has_finite_color(const ComparedImage& image, std::size_t pixel) {
  return !has_color(image) || is_finite(image.color.data() + 3 * pixel);
}

bool has_sky_layer(const ComparedImage& image) {
  return !image.ids.empty() || !image.depth.empty();
}

bool is_sky(const ComparedImage& image, std::size_t pixel) {
  return image.ids.empty() ? !is_depth(image.depth[pixel]) : image.ids[pixel] == 0;
}

/// Leaves the pixels that are inside (1) of the rectangles or outside (0); all pixels without rectangles.
void keep_covered(ImageMask& mask, const ComparedImage& image, std::span<const image::PixelBox> rectangles,
                  std::uint8_t kept) {
  if (rectangles.empty()) return;
  std::vector<std::uint8_t> covered(image.pixels(), 0);
  for (const image::PixelBox& rectangle : rectangles) {
    const int left = std::clamp(rectangle.left, 0, image.width);
    const int right = std::clamp(rectangle.right, left, image.width);
    for (int y = std::max(rectangle.top, 0); y < std::min(rectangle.bottom, image.height); ++y) {
      const auto row = covered.begin() + static_cast<std::ptrdiff_t>(y) * image.width;
      std::fill(row + left, row + right, std::uint8_t{1});
    }
  }
  keep(mask, image.pixels(), [&](std::size_t pixel) { return covered[pixel] == kept; });
}

}  // namespace

ComparedImage in_size(const ComparedImage& image, int width, int height) {
  ComparedImage result;
  result.file = image.file;
  result.width = width;
  result.height = height;
  result.encoding = image.encoding;
  result.color_channels = image.color_channels;
  result.metadata = image.metadata;
  return result;
}

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
  throw SizeMismatch(test.file.string(), {}, "the size differs from the reference " + reference.file.string(),
                     text_of(reference) + ", or --resize reference", text_of(test));
}

void require_colors(const ComparedImage& reference, const ComparedImage& test, const char* problem) {
  require_same_size(reference, test);
  for (const ComparedImage* const image : {&reference, &test})
    if (image->color_channels == 0)
      throw Error({.file = image->file.string(), .problem = problem, .expected = "channels R G B"});
}

ComparedImage cropped(const ComparedImage& image, const image::PixelBox& rectangle) {
  const bool is_inside = rectangle.left >= 0 && rectangle.top >= 0 && rectangle.right <= image.width &&
                         rectangle.bottom <= image.height;
  if (!is_inside || rectangle.left >= rectangle.right || rectangle.top >= rectangle.bottom) {
    throw Error(image.file.string(), {}, "the crop is empty or exceeds the image",
                "a rectangle inside " + text_of(image),
                "columns " + std::to_string(rectangle.left) + " to " + std::to_string(rectangle.right) +
                    ", rows " + std::to_string(rectangle.top) + " to " + std::to_string(rectangle.bottom));
  }
  ComparedImage result = in_size(image, rectangle.right - rectangle.left, rectangle.bottom - rectangle.top);
  result.origin_x = image.origin_x + rectangle.left;
  result.origin_y = image.origin_y + rectangle.top;
  result.largest_code = image.largest_code;
  result.color = part(image.color, image.width, rectangle, 3);
  result.alpha = part(image.alpha, image.width, rectangle, 1);
  result.depth = part(image.depth, image.width, rectangle, 1);
  result.depth_sigma = part(image.depth_sigma, image.width, rectangle, 1);
  result.normals = part(image.normals, image.width, rectangle, 3);
  result.ids = part(image.ids, image.width, rectangle, 1);
  return result;
}

std::uint64_t counted_pixels(const ImageMask& mask, std::size_t pixels) {
  if (mask.counts.empty()) return pixels;
  return static_cast<std::uint64_t>(
      std::ranges::count_if(mask.counts, [](std::uint8_t counts) { return counts != 0; }));
}

void keep_light(ImageMask& mask, const ComparedImage& mask_image, const ComparedImage& image) {
  // Masks are often drawn in formats without a data window, so only the size must be that of the image.
  if (mask_image.width != image.width || mask_image.height != image.height) {
    throw SizeMismatch(mask_image.file.string(), {}, "the mask size differs from " + image.file.string(),
                       image::size_text({image.width, image.height}),
                       image::size_text({mask_image.width, mask_image.height}));
  }
  if (!has_color(mask_image)) {
    throw Error(mask_image.file.string(), {}, "the mask has no colour",
                "light pixels to compare, dark pixels to ignore");
  }
  const std::vector<float> color = display_color(mask_image);
  keep(mask, image.pixels(), [&](std::size_t pixel) {
    return color[3 * pixel] + color[3 * pixel + 1] + color[3 * pixel + 2] > 1.5f;
  });
}

void keep_alpha(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test, float least) {
  if (reference.alpha.empty() && test.alpha.empty())
    fail_layer("--opaque requires alpha", "alpha", reference, test);
  for (const std::vector<float>* const alpha : {&reference.alpha, &test.alpha})
    if (!alpha->empty()) keep(mask, alpha->size(), [&](std::size_t i) { return (*alpha)[i] >= least; });
}

void keep_valid_depth(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test) {
  if (reference.depth.empty() && test.depth.empty())
    fail_layer("--valid-depth requires depth", "depth (channel Z)", reference, test);
  for (const std::vector<float>* const depth : {&reference.depth, &test.depth})
    if (!depth->empty()) keep(mask, depth->size(), [&](std::size_t i) { return is_depth((*depth)[i]); });
}

void ignore_sky(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test) {
  const bool in_reference = has_sky_layer(reference), in_test = has_sky_layer(test);
  if (!in_reference && !in_test)
    fail_layer("--ignore-sky requires ids or depth", "ids (channel id) or depth (channel Z)", reference,
               test);
  keep(mask, reference.pixels(), [&](std::size_t pixel) {
    return (in_reference && !is_sky(reference, pixel)) || (in_test && !is_sky(test, pixel));
  });
}

void keep_rectangles(ImageMask& mask, const ComparedImage& image,
                     std::span<const image::PixelBox> rectangles) {
  keep_covered(mask, image, rectangles, 1);
}

void ignore_rectangles(ImageMask& mask, const ComparedImage& image,
                       std::span<const image::PixelBox> rectangles) {
  keep_covered(mask, image, rectangles, 0);
}

std::uint64_t keep_finite(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test) {
  // Whole numbers are always finite.
  if (reference.encoding == ColorEncoding::display && test.encoding == ColorEncoding::display) return 0;
  const auto stays = [&](std::size_t pixel) {
    return has_finite_color(reference, pixel) && has_finite_color(test, pixel);
  };
  // Most images have none of them, and need no copy of the mask then.
  const std::size_t pixels = reference.pixels();
  const std::uint64_t taken = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, pixels, 65536), std::uint64_t{0},
      [&](const auto& range, std::uint64_t count) {
        for (std::size_t pixel = range.begin(); pixel != range.end(); ++pixel)
          if (mask.at(pixel) && !stays(pixel)) ++count;
        return count;
      },
      std::plus<>());
  if (taken > 0) keep(mask, pixels, stays);
  return taken;
}

}  // namespace alidade::compare
