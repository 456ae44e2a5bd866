// SPDX-License-Identifier: MIT
#include "compare/difference_map.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "compare/srgb_curve.h"

namespace alidade {
namespace {

constexpr float k_none = std::numeric_limits<float>::quiet_NaN();

/// Sets the value of every pixel, in parallel.
template <typename Value>
void fill_values(DifferenceMap& map, const Value& value) {
  map.values.resize(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, map.values.size(), 65536), [&](const auto& pixels) {
    for (std::size_t i = pixels.begin(); i != pixels.end(); ++i) map.values[i] = value(i);
  });
}

/// What a map's numbers come to.
struct MapSummary {
  double mean = 0.0, mean_magnitude = 0.0;  ///< of the finite ones
  double high = 0.0;                        ///< the percentile of the finite magnitudes that was asked for
  float largest = 0.0f;   ///< the finite one of largest magnitude, the first in reading order
  std::size_t pixel = 0;  ///< where that is
  std::size_t count = 0;  ///< of finite ones that count
};

MapSummary summary_of(const DifferenceMap& map, double percentile) {
  MapSummary summary;
  std::vector<float> magnitudes;
  magnitudes.reserve(map.values.size());
  double sum = 0.0, magnitude_sum = 0.0;
  for (std::size_t i = 0; i < map.values.size(); ++i) {
    const float value = map.values[i];
    if (!map.mask.at(i) || !std::isfinite(value)) continue;
    magnitudes.push_back(std::abs(value));
    sum += static_cast<double>(value);
    magnitude_sum += static_cast<double>(std::abs(value));
    if (std::abs(value) > std::abs(summary.largest)) {
      summary.largest = value;
      summary.pixel = i;
    }
  }
  summary.count = magnitudes.size();
  if (magnitudes.empty()) return summary;
  const auto count = static_cast<double>(magnitudes.size());
  summary.mean = sum / count;
  summary.mean_magnitude = magnitude_sum / count;
  const auto rank = magnitudes.begin() + static_cast<std::ptrdiff_t>(percentile / 100.0 * (count - 1.0));
  std::ranges::nth_element(magnitudes, rank);
  summary.high = static_cast<double>(*rank);
  return summary;
}

void add_notes(DifferenceMap& map, const MapSummary& summary, const std::string& unit) {
  if (summary.count == 0) {
    map.notes.push_back("no pixel can be compared");
    return;
  }
  const auto width = static_cast<std::size_t>(map.width);
  map.notes.push_back(fmt::format("mean {}{:.4g}{}",
                                  map.colors == DifferenceColors::balance ? "magnitude " : "",
                                  summary.mean_magnitude, unit));
  map.notes.push_back(fmt::format("largest {:.4g}{} at ({}, {})", static_cast<double>(summary.largest), unit,
                                  summary.pixel % width, summary.pixel / width));
}

DifferenceMap empty_map(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  require_same_size(reference, test);
  DifferenceMap map;
  map.width = reference.width;
  map.height = reference.height;
  map.mask = mask;
  return map;
}

float display_value(const ComparedImage& image, const CurveTable& curve, std::size_t value) {
  const float stored = image.color[value];
  return image.encoding == ColorEncoding::display ? stored : curve.at(stored);
}

}  // namespace

DifferenceMap color_difference(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask) {
  DifferenceMap map = empty_map(reference, test, mask);
  assert(reference.color.size() == 3 * reference.pixels() && test.color.size() == 3 * test.pixels());
  const CurveTable& curve = srgb_from_linear_table();
  fill_values(map, [&](std::size_t pixel) {
    float largest = 0.0f;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      if (!std::isfinite(reference.color[i]) || !std::isfinite(test.color[i])) return k_none;
      largest =
          std::max(largest, std::abs(display_value(test, curve, i) - display_value(reference, curve, i)));
    }
    return largest;
  });
  map.title = "Difference of colours";
  map.label = "largest channel (white = 1)";
  constexpr double k_percentile = 99.5;
  const MapSummary summary = summary_of(map, k_percentile);
  map.range = {0.0, std::clamp(summary.high, 1.0 / 255.0, 1.0)};
  add_notes(map, summary, "");
  return map;
}

DifferenceMap flip_difference(std::span<const float> flip, int width, const ImageMask& mask) {
  DifferenceMap map;
  map.title = "FLIP";
  map.label = "FLIP (0 = alike, 1 = most)";
  map.width = width;
  map.height = static_cast<int>(flip.size() / static_cast<std::size_t>(width));
  map.values.assign(flip.begin(), flip.end());
  map.mask = mask;
  map.range = {0.0, 1.0};
  add_notes(map, summary_of(map, 100.0), "");
  return map;
}

DifferenceMap depth_difference(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask) {
  DifferenceMap map = empty_map(reference, test, mask);
  assert(reference.depth.size() == reference.pixels() && test.depth.size() == test.pixels());
  // What lies infinitely far away in one picture only becomes infinite, in both NaN.
  fill_values(map, [&](std::size_t pixel) { return test.depth[pixel] - reference.depth[pixel]; });
  map.title = "Difference of depth";
  map.label = "test - reference (m)";
  map.colors = DifferenceColors::balance;
  constexpr double k_percentile = 98.0, k_least_range = 0.001;
  const MapSummary summary = summary_of(map, k_percentile);
  const double range = std::max(summary.high, k_least_range);
  map.range = {-range, range};
  if (summary.count > 0) map.notes.push_back(fmt::format("mean {:.4g} m", summary.mean));
  add_notes(map, summary, " m");
  return map;
}

}  // namespace alidade
