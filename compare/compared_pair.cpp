// SPDX-License-Identifier: MIT
#include "compare/compared_pair.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include "compare/resize_image.h"

namespace alidade {
namespace {

ImageMask cropped_mask(const ImageMask& mask, int width, const PixelRectangle& crop) {
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

/// FLIP takes display pictures as they are.
void remark_unused(const FlipOptions& flip, const ComparedImage& reference,
                   std::vector<std::string>& remarks) {
  const bool is_asked =
      flip.start_exposure || flip.stop_exposure || flip.exposures || flip.tone_mapper != ToneMapper::aces;
  if (is_asked && reference.encoding == ColorEncoding::display)
    remarks.push_back("exposures and tone mapper are for linear light, and the reference holds sRGB codes");
}

void remark_differences(const ComparedImage& reference, const ComparedImage& test,
                        std::vector<std::string>& remarks) {
  const auto tell = [&](const char* what, bool first, bool second) {
    if (first != second)
      remarks.push_back(
          fmt::format("only the {} has {}, which is not compared", first ? "reference" : "test", what));
  };
  tell("colours", !reference.color.empty(), !test.color.empty());
  tell("the layer of depth", !reference.depth.empty(), !test.depth.empty());
  tell("the layer of normals", !reference.normals.empty(), !test.normals.empty());
  tell("the layer of ids", !reference.ids.empty(), !test.ids.empty());
  tell("alpha", !reference.alpha.empty(), !test.alpha.empty());
  if (reference.color.empty() || test.color.empty()) return;
  if (reference.encoding != test.encoding)
    remarks.push_back(
        "one picture holds sRGB codes, the other linear light: both are compared as shown on a screen");
  if (reference.color_channels != test.color_channels)
    remarks.push_back(fmt::format("the {} is grey, the other picture is not",
                                  reference.color_channels == 1 ? "reference" : "test"));
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
  remark_differences(pair.reference, pair.test, remarks);
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

}  // namespace alidade
