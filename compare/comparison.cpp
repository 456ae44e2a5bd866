// SPDX-License-Identifier: MIT
#include "compare/comparison.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "compare/compared_pair.h"
#include "compare/metrics/ssim.h"

namespace alidade::compare {

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

namespace {

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
