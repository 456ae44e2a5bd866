// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "image/point_color.h"

namespace alidade::image {

/// One colour with a meaning of its own.
struct Swatch {
  Color16 color{0};      ///< display-referred
  std::string number{};  ///< of a class, or of returns
  std::string label{};
  std::optional<std::uint64_t> count{};  ///< points that have it
};

/// Colours along numbers.
struct ColorScale {
  ColorMap map = ColorMap::viridis;
  ValueRange range{};                       ///< values of the first and last colour
  ValueRange extent{};                      ///< smallest and largest value
  std::optional<ValueRange> percentiles{};  ///< where the range came from; empty: it was given
  /// Tick labels count from here: times are read as seconds since a date.
  double origin = 0.0;
  std::string origin_text{};  ///< what the labels' 0 is; empty if it is the value 0
};

/// The meaning of a cloud's colours, for notes, metadata and legends.
struct ColorKey {
  PointColor by = PointColor::rgb;
  std::string word = "rgb";  ///< in scene files and on command lines
  std::string title{};       ///< for people: "Height"
  std::string unit{};        ///< "m", "ft", "s", "degrees", or empty
  std::optional<ColorScale> scale{};
  std::vector<Swatch> swatches{};  ///< classes, numbers of returns, few whole numbers, directions of normals
  std::uint64_t point_count = 0;
  std::uint64_t missing_count = 0;  ///< points without a value, shown in k_no_value_color
};

/// Of points without a value: middle grey.
inline constexpr Color16 k_no_value_color{32896};

/// Title with its unit: "Height (m)".
std::string title_text(const ColorKey& key);

/// "599.13 to 611.2": both ends, less `origin`, with as many digits as distinguish them and no more than
/// people read.
std::string range_text(const ValueRange& range, double origin = 0.0);

/// The scale as a sentence: "599.13 to 611.2 m (percentiles 1 to 99; all 598 to 623 m), colour map terrain".
/// Values count from the scale's origin, which is then stated as well, as in legends: "0
/// to 2500 s (...); 0 s = 2024-06-09 20:27:06 GPS time, ...". Empty without a scale.
std::string scale_text(const ColorKey& key);

/// Keys and texts for the metadata of images: alidade:color_by, and with a scale alidade:color_map and
/// alidade:color_range (low and high, 17 significant digits).
std::vector<std::pair<std::string, std::string>> color_metadata(const ColorKey& key);

/// Errors: a legend would be empty, since the colours are the points' own, or there are no points.
void check_legend(const ColorKey& key);

}  // namespace alidade::image
