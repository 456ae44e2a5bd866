// SPDX-License-Identifier: MIT
#include "compare/image_mask.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace alidade::compare {
namespace {

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

bool tells_sky(const ComparedImage& image) {
  return !image.ids.empty() || !image.depth.empty();
}

bool is_sky(const ComparedImage& image, std::size_t pixel) {
  return image.ids.empty() ? !is_depth(image.depth[pixel]) : image.ids[pixel] == 0;
}

std::vector<std::uint8_t> inside(const ComparedImage& image, std::span<const PixelRectangle> rectangles) {
  std::vector<std::uint8_t> covered(image.pixels(), 0);
  for (const PixelRectangle& rectangle : rectangles) {
    const int left = std::clamp(rectangle.left, 0, image.width);
    const int right = std::clamp(rectangle.right, left, image.width);
    for (int y = std::max(rectangle.top, 0); y < std::min(rectangle.bottom, image.height); ++y) {
      const auto row = covered.begin() + static_cast<std::ptrdiff_t>(y) * image.width;
      std::fill(row + left, row + right, std::uint8_t{1});
    }
  }
  return covered;
}

}  // namespace

std::uint64_t counted_pixels(const ImageMask& mask, std::size_t pixels) {
  if (mask.counts.empty()) return pixels;
  return static_cast<std::uint64_t>(
      std::ranges::count_if(mask.counts, [](std::uint8_t counts) { return counts != 0; }));
}

void keep_light(ImageMask& mask, const ComparedImage& mask_image, const ComparedImage& image) {
  // Masks are often drawn in formats without a data window, so only the size must be that of the image.
  const auto size_of = [](const ComparedImage& of) {
    return std::to_string(of.width) + " x " + std::to_string(of.height);
  };
  if (mask_image.width != image.width || mask_image.height != image.height) {
    throw SizeMismatch({.file = mask_image.file.string(),
                        .problem = "the mask size differs from " + image.file.string(),
                        .expected = size_of(image),
                        .found = size_of(mask_image)});
  }
  if (!has_color(mask_image)) {
    throw Error({.file = mask_image.file.string(),
                 .problem = "the mask has no colour",
                 .expected = "light pixels to compare, dark pixels to ignore"});
  }
  const std::vector<float> color = display_color(mask_image);
  keep(mask, image.pixels(), [&](std::size_t pixel) {
    return color[3 * pixel] + color[3 * pixel + 1] + color[3 * pixel + 2] > 1.5f;
  });
}

void keep_alpha(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test, float least) {
  if (reference.alpha.empty() && test.alpha.empty())
    fail_layer("--opaque requires alpha", "alpha", reference, test);
  for (const ComparedImage* const image : {&reference, &test}) {
    if (image->alpha.empty()) continue;
    keep(mask, image->pixels(), [&](std::size_t pixel) { return image->alpha[pixel] >= least; });
  }
}

void keep_valid_depth(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test) {
  if (reference.depth.empty() && test.depth.empty())
    fail_layer("--valid-depth requires depth", "depth (channel Z)", reference, test);
  for (const ComparedImage* const image : {&reference, &test}) {
    if (image->depth.empty()) continue;
    keep(mask, image->pixels(), [&](std::size_t pixel) { return is_depth(image->depth[pixel]); });
  }
}

void ignore_sky(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test) {
  const bool reference_tells = tells_sky(reference), test_tells = tells_sky(test);
  if (!reference_tells && !test_tells)
    fail_layer("--ignore-sky requires ids or depth", "ids (channel id) or depth (channel Z)", reference,
               test);
  keep(mask, reference.pixels(), [&](std::size_t pixel) {
    return (reference_tells && !is_sky(reference, pixel)) || (test_tells && !is_sky(test, pixel));
  });
}

void keep_rectangles(ImageMask& mask, const ComparedImage& image,
                     std::span<const PixelRectangle> rectangles) {
  if (rectangles.empty()) return;
  const std::vector<std::uint8_t> covered = inside(image, rectangles);
  keep(mask, image.pixels(), [&](std::size_t pixel) { return covered[pixel] != 0; });
}

void ignore_rectangles(ImageMask& mask, const ComparedImage& image,
                       std::span<const PixelRectangle> rectangles) {
  if (rectangles.empty()) return;
  const std::vector<std::uint8_t> covered = inside(image, rectangles);
  keep(mask, image.pixels(), [&](std::size_t pixel) { return covered[pixel] == 0; });
}

std::uint64_t keep_finite(ImageMask& mask, const ComparedImage& reference, const ComparedImage& test) {
  // Whole numbers are always finite.
  if (reference.encoding == ColorEncoding::display && test.encoding == ColorEncoding::display) return 0;
  const auto stays = [&](std::size_t pixel) {
    return has_finite_color(reference, pixel) && has_finite_color(test, pixel);
  };
  // Most pictures have none of them, and need no copy of the mask then.
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
