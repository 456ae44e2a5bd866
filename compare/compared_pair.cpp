// SPDX-License-Identifier: MIT
#include "compare/compared_pair.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "compare/metrics/agreement.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

ImageMask cropped_mask(const ImageMask& mask, int width, const image::PixelBox& crop) {
  ImageMask part;
  if (mask.counts.empty()) return part;
  for (int y = crop.top; y < crop.bottom; ++y) {
    const auto row = mask.counts.begin() + static_cast<std::ptrdiff_t>(y) * width;
    part.counts.insert(part.counts.end(), row + crop.left, row + crop.right);
  }
  return part;
}

ImageMask mask_of(const ComparedPair& pair, const ComparisonOptions& options) {
  ImageMask mask;
  if (!options.mask.empty()) keep_light(mask, read_compared_image(options.mask), pair.reference);
  if (options.use_alpha) keep_alpha(mask, pair.reference, pair.test);
  if (options.valid_depth) keep_valid_depth(mask, pair.reference, pair.test);
  if (options.ignore_sky) ignore_sky(mask, pair.reference, pair.test);
  keep_rectangles(mask, pair.reference, options.keep);
  ignore_rectangles(mask, pair.reference, options.ignore);
  return mask;
}

/// FLIP uses exposures and tone mappers only for linear light.
void remark_unused(const FlipOptions& flip, const ComparedImage& reference,
                   std::vector<std::string>& remarks) {
  const bool is_asked =
      flip.start_exposure || flip.stop_exposure || flip.exposures || flip.tone_mapper != ToneMapper::aces;
  if (is_asked && reference.encoding == ColorEncoding::display)
    remarks.push_back("exposures and tone mapper require linear light, but the reference has sRGB values");
}

void remark_differences(const ComparedImage& reference, const ComparedImage& test, bool uses_alpha,
                        std::vector<std::string>& remarks) {
  const auto warn = [&](const char* what, bool first, bool second, const char* option = "") {
    if (first != second)
      remarks.push_back(
          fmt::format("ignoring {1}: only the {0} has it{2}", first ? "reference" : "test", what, option));
  };
  warn("colours", !reference.color.empty(), !test.color.empty());
  warn("the depth layer", !reference.depth.empty(), !test.depth.empty());
  warn("the normal layer", !reference.normals.empty(), !test.normals.empty());
  warn("the id layer", !reference.ids.empty(), !test.ids.empty());
  warn("alpha", !reference.alpha.empty(), !test.alpha.empty(),
       uses_alpha ? "" : "; --opaque leaves out the pixels without a surface");
  if (reference.color.empty() || test.color.empty()) return;
  if (reference.encoding != test.encoding)
    remarks.push_back("one image has sRGB values, the other linear light: comparing display values");
  if (reference.color_channels != test.color_channels)
    remarks.push_back(fmt::format("the {} is grey, the other image is not",
                                  reference.color_channels == 1 ? "reference" : "test"));
}

std::uint8_t code(float value) {
  return static_cast<std::uint8_t>(std::lround(255.0f * (value > 0.0f ? std::min(value, 1.0f) : 0.0f)));
}

/// Makes an image of value(pixel, channel), which returns sRGB in 0 .. 1.
template <typename Value>
image::ByteImage byte_image(const ComparedImage& image, const Value& value) {
  image::ByteImage shown{image.width, image.height, std::vector<std::uint8_t>(3 * image.pixels())};
  in_parallel(image.pixels(), 1 << 16, [&](std::size_t pixel) {
    for (std::size_t c = 0; c < 3; ++c) shown.bytes[3 * pixel + c] = code(value(pixel, c));
  });
  return shown;
}

/// The largest finite depth; 0 without any.
double farthest_depth(const ComparedImage& image) {
  float farthest = 0.0f;
  for (const float depth : image.depth)
    if (std::isfinite(depth)) farthest = std::max(farthest, depth);
  return farthest;
}

/// Few enough that the 8-bit codes of small differences leave no gaps.
constexpr std::size_t k_bins = 24;

/// Lightness from black to white: Rec. 709's weights on sRGB values.
std::vector<float> lightness_of(const image::ByteImage& image) {
  std::vector<float> lightness(image.bytes.size() / 3);
  for (std::size_t i = 0; i < lightness.size(); ++i) {
    const std::uint8_t* const rgb = &image.bytes[3 * i];
    lightness[i] = (0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]) / 255.0f;
  }
  return lightness;
}

void add_map(ComparisonImages& images, std::optional<DifferenceMap>& into, DifferenceMap map,
             const char* unit) {
  const double low = map.range.low, high = map.range.high;
  if (low < high)
    images.histograms.push_back(
        {map.title, unit, low, high, count_values(map.title, map.values, map.mask, low, high, k_bins)});
  into = std::move(map);
}

}  // namespace

ComparedPair read_compared_pair(const std::filesystem::path& reference, const std::filesystem::path& test,
                                const ComparisonOptions& options, std::vector<std::string>& remarks) {
  ComparedPair pair;
  tbb::parallel_invoke([&] { pair.reference = read_compared_image(reference); },
                       [&] { pair.test = read_compared_image(test); });
  const bool same_size = pair.reference.width == pair.test.width && pair.reference.height == pair.test.height;
  if (options.resize_to_reference && !same_size) {
    remarks.push_back(
        fmt::format("the test was resized from {} x {} pixels", pair.test.width, pair.test.height));
    pair.test = resized(pair.test, pair.reference.width, pair.reference.height);
    pair.test.origin_x = pair.reference.origin_x;
    pair.test.origin_y = pair.reference.origin_y;
  }
  require_same_size(pair.reference, pair.test);
  remark_differences(pair.reference, pair.test, options.use_alpha, remarks);
  remark_unused(options.flip, pair.reference, remarks);
  pair.mask = mask_of(pair, options);
  if (options.crop) {
    const int width = pair.reference.width;
    pair.reference = cropped(pair.reference, *options.crop);
    pair.test = cropped(pair.test, *options.crop);
    pair.mask = cropped_mask(pair.mask, width, *options.crop);
  }
  return pair;
}

image::ByteImage displayed(const ComparedImage& image, double farthest) {
  if (!image.color.empty()) {
    if (image.encoding == ColorEncoding::display)
      return byte_image(image, [&](std::size_t pixel, std::size_t c) { return image.color[3 * pixel + c]; });
    const image::CurveTable& curve = image::srgb_from_linear_table();
    return byte_image(image,
                      [&](std::size_t pixel, std::size_t c) { return curve.at(image.color[3 * pixel + c]); });
  }
  if (!image.normals.empty())
    return byte_image(
        image, [&](std::size_t pixel, std::size_t c) { return 0.5f + 0.5f * image.normals[3 * pixel + c]; });
  if (!image.depth.empty()) {
    const float scale = farthest > 0.0 ? static_cast<float>(1.0 / farthest) : 0.0f;
    return byte_image(image,
                      [&](std::size_t pixel, std::size_t) { return 1.0f - image.depth[pixel] * scale; });
  }
  return byte_image(image, [&](std::size_t pixel, std::size_t c) {
    // Knuth's multiplicative hash spreads neighbouring ids over the colours.
    const std::uint32_t hash = image.ids[pixel] * 2654435761u;
    return image.ids[pixel] == 0 ? 0.0f : static_cast<float>(hash >> (8 * c) & 255u) / 255.0f;
  });
}

std::vector<const DifferenceMap*> ComparisonImages::maps() const {
  std::vector<const DifferenceMap*> maps;
  for (const std::optional<DifferenceMap>* map : {&flip_map, &color_map, &depth_map, &agreement_map})
    if (*map) maps.push_back(&**map);
  return maps;
}

ComparisonImages shown_images(const ComparedPair& pair) {
  const double farthest = std::max(farthest_depth(pair.reference), farthest_depth(pair.test));
  ComparisonImages images;
  images.reference = displayed(pair.reference, farthest);
  images.test = displayed(pair.test, farthest);
  return images;
}

void add_maps(ComparisonImages& images, const ComparedPair& pair, PairMaps made, std::vector<float> flip) {
  const ImageMask& mask = pair.mask;
  if (pair.have_colors()) {
    const char* const matched = images.matched ? ", colours matched" : "";
    const auto add_color_map = [&](std::optional<DifferenceMap>& into, DifferenceMap map) {
      map.title += matched;
      add_map(images, into, std::move(map), "");
    };
    add_color_map(images.flip_map, flip_difference(std::move(flip), pair.reference.width, mask));
    add_color_map(images.color_map,
                  made.color ? std::move(*made.color) : color_difference(pair.reference, pair.test, mask));
    const image::ByteImage& test = images.matched ? *images.matched : images.test;
    images.histograms.push_back(
        {"Lightness", "", 0.0, 1.0, count_values("reference", lightness_of(images.reference), mask, 0.0, 1.0),
         count_values(std::string("test") + matched, lightness_of(test), mask, 0.0, 1.0)});
  }
  if (pair.have_depth())
    add_map(images, images.depth_map,
            made.depth ? std::move(*made.depth) : depth_difference(pair.reference, pair.test, mask), "m");
  if (have_agreement(pair.reference, pair.test))
    images.agreement_map = depth_agreement(pair.reference, pair.test, mask);
}

}  // namespace alidade::compare
