// SPDX-License-Identifier: MIT
#include "compare/difference_map.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "compare/metrics/row_sums.h"
#include "image/srgb.h"

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

/// What a map's numbers come to: those that count and are finite.
DifferenceSums<double> sums_of(const DifferenceMap& map) {
  const auto width = static_cast<std::size_t>(map.width);
  return sum_rows<DifferenceSums<double>>(static_cast<std::size_t>(map.height),
                                          [&](std::size_t y, DifferenceSums<double>& sums) {
                                            for (std::size_t i = y * width; i < (y + 1) * width; ++i)
                                              if (map.mask.at(i) && std::isfinite(map.values[i]))
                                                sums.add(static_cast<double>(map.values[i]), i);
                                          });
}

/// The magnitude that so many of a hundred do not exceed; 0 without any.
double percentile_of(const DifferenceMap& map, double percent, std::uint64_t count) {
  if (count == 0) return 0.0;
  const auto magnitude_at = [&](std::size_t i) {
    return map.mask.at(i) && std::isfinite(map.values[i]) ? std::abs(map.values[i]) : -1.0f;
  };
  const auto rank = static_cast<std::uint64_t>(percent / 100.0 * static_cast<double>(count - 1));
  const std::size_t size = map.values.size();
  return static_cast<double>(value_of_rank(size, magnitude_at, count_upper_halves(size, magnitude_at), rank));
}

void add_notes(DifferenceMap& map, const DifferenceSums<double>& sums, const std::string& unit) {
  if (sums.values == 0) {
    map.notes.push_back("no pixel can be compared");
    return;
  }
  const auto width = static_cast<std::size_t>(map.width);
  map.notes.push_back(fmt::format("mean {}{:.4g}{}",
                                  map.colors == DifferenceColors::balance ? "magnitude " : "",
                                  sums.mean(sums.sum_abs), unit));
  const double largest = sums.most > 0.0 ? static_cast<double>(map.values[sums.most_at]) : 0.0;
  map.notes.push_back(
      fmt::format("largest {:.4g}{} at ({}, {})", largest, unit, sums.most_at % width, sums.most_at / width));
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
  const DifferenceSums<double> sums = sums_of(map);
  map.range = {0.0, std::clamp(percentile_of(map, k_percentile, sums.values), 1.0 / 255.0, 1.0)};
  add_notes(map, sums, "");
  return map;
}

DifferenceMap flip_difference(std::vector<float> flip, int width, const ImageMask& mask) {
  DifferenceMap map;
  map.title = "FLIP";
  map.label = "FLIP (0 = alike, 1 = most)";
  map.width = width;
  map.height = static_cast<int>(flip.size() / static_cast<std::size_t>(width));
  map.values = std::move(flip);
  map.mask = mask;
  map.range = {0.0, 1.0};
  add_notes(map, sums_of(map), "");
  return map;
}

DifferenceMap depth_difference(const ComparedImage& reference, const ComparedImage& test,
                               const ImageMask& mask) {
  DifferenceMap map = empty_map(reference, test, mask);
  assert(reference.depth.size() == reference.pixels() && test.depth.size() == test.pixels());
  constexpr float k_infinite = std::numeric_limits<float>::infinity();
  fill_values(map, [&](std::size_t pixel) {
    const bool in_reference = is_depth(reference.depth[pixel]), in_test = is_depth(test.depth[pixel]);
    if (in_reference && in_test) return test.depth[pixel] - reference.depth[pixel];
    return in_reference ? k_infinite : in_test ? -k_infinite : k_none;
  });
  map.title = "Difference of depth";
  map.label = "test - reference (m)";
  map.colors = DifferenceColors::balance;
  constexpr double k_percentile = 98.0, k_least_range = 0.001;
  const DifferenceSums<double> sums = sums_of(map);
  const double range = std::max(percentile_of(map, k_percentile, sums.values), k_least_range);
  map.range = {-range, range};
  if (sums.values > 0) map.notes.push_back(fmt::format("mean {:.4g} m", sums.mean(sums.sum)));
  add_notes(map, sums, " m");
  return map;
}

}  // namespace alidade
