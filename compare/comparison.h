// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "compare/change_regions.h"
#include "compare/compared_image.h"
#include "compare/difference_map.h"
#include "compare/metrics/errors.h"
#include "compare/metrics/flip.h"
#include "compare/photographs/alignment.h"
#include "compare/photographs/color_match.h"
#include "image/encoded_image.h"

namespace alidade::compare {

/// How often values occur: equal steps from `low` to `high`, values outside of them in the first and last.
struct Histogram {
  std::string name;
  std::vector<std::uint64_t> bins;
};

/// Histograms that are drawn into one chart.
struct HistogramChart {
  std::string title, unit;
  double low = 0.0, high = 1.0;
  Histogram first;
  std::optional<Histogram> second{};
};

/// Counts values of pixels that count, in one pass, without NaN and infinity. Requires low < high, bins >= 1.
Histogram count_values(std::string name, std::span<const float> values, const ImageMask& mask, double low,
                       double high, std::size_t bins = 64);

// The whole run: from two files to one result. Thresholds, JSON and reports are made from it.
//
//   const Comparison comparison = compare_files("reference.png", "test.png", {});
//   const Verdict verdict = judge(comparison, parse_thresholds("flip=0.05,psnr<30"));

/// The map in which regions of change are searched.
enum class ChangeMap {
  flip,   ///< what people see, 0 .. 1
  color,  ///< largest difference of the three channels, 0 .. 1
  depth   ///< metres
};

struct ComparisonOptions {
  // Which pixels count: those that all of these options leave.
  /// The part of both images to compare; pixels in the result count from its top left corner.
  std::optional<image::PixelBox> crop;
  bool resize_to_reference = false;  ///< otherwise another size is SizeMismatch
  std::filesystem::path mask;        ///< keep_light(); of the size of the reference before cropping
  bool use_alpha = false, valid_depth = false, ignore_sky = false;
  std::vector<image::PixelBox> keep, ignore;  ///< in pixels of the reference before cropping

  FlipOptions flip;

  std::optional<ColorModel> match;  ///< fits colours; figures are then computed for matched ones, too
  bool align = false;
  int largest_shift = 64;  ///< pixels

  std::optional<ChangeMap> find_changes;  ///< of matched colours where they are
  ChangeOptions changes;

  bool keep_images = false;  ///< for reports and maps
};

/// Facts about an image, from its file.
struct ComparedImageFacts {
  std::filesystem::path file;
  int width = 0, height = 0;  ///< as compared
  ColorEncoding encoding = ColorEncoding::display;
  std::vector<std::pair<std::string, std::string>> metadata;
  std::vector<std::uint32_t> ids;  ///< the id layer, for points behind regions; kept if changes are searched
};

/// Figures of colours.
struct ColorFigures {
  ErrorMetrics stored;   ///< of the values in the files; of display values if only one file is linear
  ErrorMetrics linear;   ///< of linear light
  ErrorMetrics display;  ///< of sRGB values in 0 .. 1
  double ssim = 0.0, ms_ssim = 0.0;
  FlipResult flip;  ///< the map only while it is needed
};

/// Images and maps for people.
struct ComparisonImages {
  image::ByteImage reference, test;
  std::optional<image::ByteImage> matched;  ///< the test with matched colours
  std::optional<DifferenceMap> color_map, flip_map, depth_map, agreement_map;
  std::vector<HistogramChart> histograms;

  /// Those of FLIP, colours, depth and agreement that were made, in this order.
  std::vector<const DifferenceMap*> maps() const;
};

struct Comparison {
  ComparisonOptions options;  ///< those of the run
  ComparedImageFacts reference, test;
  std::uint64_t pixels = 0;    ///< of the compared part
  std::uint64_t counted = 0;   ///< of them, those that masks let count
  std::uint64_t excluded = 0;  ///< of the counted ones, those with NaN or infinite colours, in no figure
  std::vector<std::string> remarks;  ///< what limits the meaning of the figures

  std::optional<ColorFigures> color;  ///< both images have colours
  LayerMetrics layers;                ///< of the layers that both images have
  std::optional<ColorMatch> match;
  std::optional<ColorFigures> matched;  ///< of the test with matched colours
  std::optional<Alignment> alignment;
  std::optional<ChangeRegions> changes;
  std::optional<ComparisonImages> images;
};

/// Compares two files. Errors: those of read_compared_image(); SizeMismatch; masks of layers that neither
/// file has; a crop outside of the image; nothing in common (one has colours only, the other layers only);
/// matching, aligning or changes requested of layers that are missing. Progress counts steps of the run.
/// Cost: see docs/compare.md. Equal results on any number of threads.
Comparison compare_files(const std::filesystem::path& reference, const std::filesystem::path& test,
                         const ComparisonOptions& options, const Progress& progress = {});

}  // namespace alidade::compare
