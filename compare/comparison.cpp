// SPDX-License-Identifier: MIT
#include "compare/comparison.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "compare/metrics/agreement.h"
#include "compare/metrics/ssim.h"
#include "compare/read_compared_image.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

/// Two images of one size and the mask of pixels that count.
struct ComparedPair {
  ComparedImage reference, test;
  ImageMask mask;

  bool have_colors() const { return !reference.color.empty() && !test.color.empty(); }
  bool have_depth() const { return !reference.depth.empty() && !test.depth.empty(); }
};

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

/// Reads both, then resizes the test, masks and crops by the options. `remarks` gets the differences of
/// sizes, layers and encodings. Errors: those of compare_files() that concern files, sizes, masks and crops.
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

/// An image as a screen shows it: its colours in sRGB, cut off at black and white. Without colours its
/// normals (x, y, z from -1 .. 1 as red, green, blue), else its depth (white at 0, black at `farthest` and
/// beyond), else its ids (every point has a colour of its own). NaN is black.
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

/// Both images as screens show them. To be called before colours are matched.
ComparisonImages shown_images(const ComparedPair& pair) {
  const double farthest = std::max(farthest_depth(pair.reference), farthest_depth(pair.test));
  ComparisonImages images;
  images.reference = displayed(pair.reference, farthest);
  images.test = displayed(pair.test, farthest);
  return images;
}

/// Maps of a pair that were made for something else, or are still to be made.
struct PairMaps {
  std::optional<DifferenceMap> color, depth;
};

/// Adds maps and histograms of the layers that the pair has, and uses those of `made`. `flip`: map of FLIP,
/// if there are colours. If the test has matched colours (images.matched), titles mention it.
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

void require(bool holds, const ComparedImage& image, const char* problem, const char* expected) {
  if (!holds) throw Error({.file = image.file.string(), .problem = problem, .expected = expected});
}

/// Empties a list and returns its memory, which assigning an empty one would keep.
template <typename Value>
void give_back(std::vector<Value>& values) {
  std::vector<Value>().swap(values);
}

ComparedImageFacts facts_of(const ComparedImage& image) {
  return {image.file, image.width, image.height, image.encoding, image.metadata, {}};
}

/// One comparison in progress. Reports steps of about equal cost, counted in pixels.
class ComparisonRun {
 public:
  ComparisonRun(ComparedPair pair, const ComparisonOptions& options, const Progress& progress,
                Comparison& comparison)
      : pair_(std::move(pair)), options_(options), progress_(progress), comparison_(comparison) {
    const std::uint64_t sets = !pair_.have_colors() ? 0 : options.match ? 2 : 1;
    steps_ = sets * k_steps_of_colors + 4;
  }

  void compare() {
    count();
    done();
    compare_layers();
    if (pair_.have_colors()) comparison_.color = figures();
    if (options_.keep_images) comparison_.images = shown_images(pair_);
    if (options_.align) align_edges();
    done();
    if (options_.match) match_colors();
    if (options_.find_changes) find_changes();
    done();
    if (comparison_.images) add_maps(*comparison_.images, pair_, std::move(maps_), std::move(flip_map()));
    for (std::optional<ColorFigures>* const set : {&comparison_.color, &comparison_.matched})
      if (*set) give_back((*set)->flip.map);
    done();
  }

 private:
  static constexpr std::uint64_t k_steps_of_colors = 3;

  void done(std::uint64_t steps = 1) {
    done_ += steps;
    report(progress_, done_ * comparison_.pixels, steps_ * comparison_.pixels);
  }

  /// How many pixels can be compared; errors if none.
  void count() {
    comparison_.pixels = pair_.reference.pixels();
    comparison_.counted = counted_pixels(pair_.mask, pair_.reference.pixels());
    require(comparison_.counted > 0, pair_.reference, "no pixels to compare", "masks that keep some pixels");
    if (!pair_.have_colors()) return;
    ImageMask finite = pair_.mask;
    comparison_.excluded = keep_finite(finite, pair_.reference, pair_.test);
    require(comparison_.excluded < comparison_.counted, pair_.test,
            "no pixel has finite colours in both images", "at least one");
    if (comparison_.excluded > 0)
      remark(fmt::format("ignoring {} pixels with NaN or infinite colours", comparison_.excluded));
  }

  void compare_layers() {
    const LayerMetrics layers = comparison_.layers = layer_metrics(pair_.reference, pair_.test, pair_.mask);
    require(pair_.have_colors() || layers.depth || layers.normals || layers.ids, pair_.test,
            "nothing to compare with the reference", "a common layer");
    const auto warn = [&](std::uint64_t pixels, const char* what) {
      if (pixels > 0) remark(fmt::format("{} pixels {}", pixels, what));
    };
    if (layers.depth) warn(layers.depth->invalid, "with NaN or negative depth are treated as background");
    if (layers.normals)
      warn(layers.normals->invalid, "with NaN or infinite normals are treated as background");
    if (layers.alpha) warn(layers.alpha->invalid, "with NaN or infinite alpha are ignored");
    for (ComparedImage* const image : {&pair_.reference, &pair_.test}) forget_layers(*image);
  }

  /// Large images need the memory for maps.
  void forget_layers(ComparedImage& image) const {
    const bool is_shown = options_.keep_images && image.color.empty();
    if (!is_shown) give_back(image.normals);
    if (!is_shown && !options_.find_changes) give_back(image.ids);
    if (!options_.match && !options_.align) give_back(image.alpha);
    if (!options_.keep_images) give_back(image.depth_sigma);
  }

  ColorFigures figures() {
    const ComparedImage &reference = pair_.reference, &test = pair_.test;
    ColorFigures figures;
    figures.linear = error_metrics(reference, test, ColorEncoding::linear, pair_.mask);
    figures.display = error_metrics(reference, test, ColorEncoding::display, pair_.mask);
    const bool is_linear =
        reference.encoding == ColorEncoding::linear && test.encoding == ColorEncoding::linear;
    figures.stored = is_linear ? figures.linear : figures.display;
    done();
    const Similarity similar = similarity(reference, test, pair_.mask);
    figures.ssim = similar.ssim;
    figures.ms_ssim = similar.ms_ssim;
    done();
    figures.flip = flip(reference, test, pair_.mask, options_.flip);
    done();
    return figures;
  }

  void align_edges() {
    require(pair_.have_colors(), pair_.test, "alignment requires colours", "colours in both images");
    const Alignment found =
        align(pair_.reference, pair_.test, pair_.mask, {.largest_shift = options_.largest_shift});
    comparison_.alignment = found;
    constexpr double k_most_shift = 0.5;
    if (!found.is_certain) {
      remark("cannot determine the shift between the images: too few common edges");
    } else if (std::hypot(found.shift_x, found.shift_y) > k_most_shift) {
      remark(fmt::format(
          "the test is shifted by {:.2f}, {:.2f} pixels relative to the reference; check its camera",
          found.shift_x, found.shift_y));
    }
  }

  /// Replaces the colours of the test by matched ones.
  void match_colors() {
    require(pair_.have_colors(), pair_.test, "matching requires colours", "colours in both images");
    comparison_.match = match_color(pair_.reference, pair_.test, pair_.mask, *options_.match);
    if (!comparison_.match) {
      remark("cannot match colours: too few pixels, or too little variation");
      done(k_steps_of_colors);
      return;
    }
    apply_color_match(pair_.test, *comparison_.match);
    comparison_.matched = figures();
    if (comparison_.images) comparison_.images->matched = displayed(pair_.test, 0.0);
  }

  void find_changes() {
    const auto find = [&](std::span<const float> map) {
      comparison_.changes = change_regions(map, pair_.reference.width, pair_.mask, options_.changes);
    };
    if (options_.find_changes == ChangeMap::depth) {
      require(pair_.have_depth(), pair_.test, "depth changes require depth in both images",
              "EXR files with the layer Z");
      maps_.depth = depth_difference(pair_.reference, pair_.test, pair_.mask);
      find(maps_.depth->values);
    } else {
      require(pair_.have_colors(), pair_.test, "colour changes require colours in both images",
              "another kind of changes");
      if (options_.find_changes == ChangeMap::color) {
        maps_.color = color_difference(pair_.reference, pair_.test, pair_.mask);
        find(maps_.color->values);
      } else {
        find(flip_map());
      }
    }
    if (!comparison_.images) maps_ = {};
    comparison_.reference.ids = std::move(pair_.reference.ids);
    comparison_.test.ids = std::move(pair_.test.ids);
  }

  /// Of matched colours if there are any; empty without colours.
  std::vector<float>& flip_map() {
    if (!comparison_.color) return no_map_;
    return (comparison_.matched ? *comparison_.matched : *comparison_.color).flip.map;
  }

  void remark(std::string text) { comparison_.remarks.push_back(std::move(text)); }

  ComparedPair pair_;
  PairMaps maps_;
  std::vector<float> no_map_;
  const ComparisonOptions& options_;
  const Progress& progress_;
  Comparison& comparison_;
  std::uint64_t steps_ = 0, done_ = 0;
};

}  // namespace

Histogram count_values(std::string name, std::span<const float> values, const ImageMask& mask, double low,
                       double high, std::size_t bins) {
  Histogram histogram{std::move(name), std::vector<std::uint64_t>(bins)};
  const double last = static_cast<double>(bins - 1), scale = static_cast<double>(bins) / (high - low);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!mask.at(i) || !std::isfinite(values[i])) continue;
    const double bin = std::clamp((values[i] - low) * scale, 0.0, last);
    ++histogram.bins[static_cast<std::size_t>(bin)];
  }
  return histogram;
}

std::vector<const DifferenceMap*> ComparisonImages::maps() const {
  std::vector<const DifferenceMap*> maps;
  for (const std::optional<DifferenceMap>* map : {&flip_map, &color_map, &depth_map, &agreement_map})
    if (*map) maps.push_back(&**map);
  return maps;
}

Comparison compare_files(const std::filesystem::path& reference, const std::filesystem::path& test,
                         const ComparisonOptions& options, const Progress& progress) {
  Comparison comparison;
  ComparedPair pair = read_compared_pair(reference, test, options, comparison.remarks);
  comparison.options = options;
  comparison.reference = facts_of(pair.reference);
  comparison.test = facts_of(pair.test);
  ComparisonRun(std::move(pair), options, progress, comparison).compare();
  return comparison;
}

}  // namespace alidade::compare
