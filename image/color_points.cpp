// SPDX-License-Identifier: MIT
#include "image/color_points.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "cloud/point_cloud.h"
#include "geo/map_unit.h"
#include "image/classification_colors.h"
#include "image/gps_date.h"
#include "image/point_values.h"
#include "image/stretch.h"

namespace alidade {
namespace {

ColorMap usual_map(PointColor by) {
  if (by == PointColor::intensity) return ColorMap::grey;
  return by == PointColor::height ? ColorMap::terrain : ColorMap::viridis;
}

/// "point_source_id" -> "Point source id".
std::string title_of(const std::string& word) {
  std::string title = word;
  std::ranges::replace(title, '_', ' ');
  if (!title.empty() && title[0] >= 'a' && title[0] <= 'z')
    title[0] = static_cast<char>(title[0] - 'a' + 'A');
  return title;
}

/// The kind of clock in words, and where on it the labels' 0 lies.
std::string time_origin(double origin, const PointCloud& facts) {
  const bool las = std::ranges::all_of(facts.files, is_las);
  if (std::fabs(origin) < 1e15) {
    const auto seconds = static_cast<std::int64_t>(origin);
    if (facts.gps_time_is_standard) {
      if (const auto date = gps_date(seconds)) return "0 s = " + *date + " GPS time";
    } else if (las) {
      if (const auto weekday = gps_weekday(seconds)) return "0 s = " + *weekday + " of the GPS week";
    }
    return "0 s = " + std::to_string(seconds) + " s in the file";
  }
  return "";
}

/// The title, its unit, and how ticks are counted.
void describe(const PointColoring& coloring, const PointCloud& facts, ColorKey& key) {
  key.word = color_word(coloring);
  key.title = title_of(key.word);
  if (key.by == PointColor::height) key.unit = height_unit(facts.crs);
  if (key.by == PointColor::attribute && key.word == "scan_angle") key.unit = std::string("degrees");
  if (key.by != PointColor::gps_time) return;
  key.title = std::string("GPS time");
  key.unit = std::string("s");
  const ValueRange& range = key.scale->range;
  // A whole second, within the range if there is one, so that the labels' 0 is on the scale.
  const double origin = std::ceil(range.low) <= range.high ? std::ceil(range.low) : std::floor(range.low);
  key.scale->origin_text = time_origin(origin, facts);
  if (!key.scale->origin_text.empty()) key.scale->origin = origin;
}

/// color_of(value) for every point that has one.
template <class ColorOf>
std::vector<Color16> colors_by(const PointValues& values, const ColorOf& color_of) {
  std::vector<Color16> colors(values.count);
  values.for_each_block([&](const ValueBlock& block) {
    for (std::size_t i = 0; i < block.values.size(); ++i) {
      const double value = block.values[i];
      colors[block.id(i)] = std::isnan(value) ? k_no_value_color : color_of(value);
    }
  });
  return colors;
}

ColoredPoints by_scale(const PointColoring& coloring, const PointValues& values) {
  const ValueExtent extent = extent_of(values);
  ColorScale scale{.map = coloring.map.value_or(usual_map(coloring.by)), .extent = extent.range};
  if (coloring.range) {
    scale.range = *coloring.range;
  } else {
    scale.percentiles = coloring.percentiles;
    scale.range = percentiles_of(values, extent, coloring.percentiles);
  }
  ColoredPoints points;
  points.colors = colors_by(
      values, [&](double value) { return to_color16(map_color(scale.map, place_in(scale.range, value))); });
  points.key.missing_count = values.count - extent.count;
  points.key.scale = scale;
  return points;
}

/// How many points have each whole number from 0 to 255.
std::array<std::uint64_t, 256> counts_of(const PointValues& values) {
  using Counts = std::array<std::uint64_t, 256>;
  tbb::enumerable_thread_specific<Counts> of_threads(Counts{});
  values.for_each_block([&](const ValueBlock& block) {
    Counts& counts = of_threads.local();
    for (const double value : block.values) {
      if (!std::isnan(value)) ++counts[static_cast<std::uint8_t>(value)];
    }
  });
  Counts sums{};
  for (const Counts& counts : of_threads) {
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += counts[i];
  }
  return sums;
}

ColoredPoints by_class(const PointColoring& coloring, const PointValues& values) {
  const std::array<ClassStyle, 256> styles = class_styles(coloring.classes);
  const std::array<std::uint64_t, 256> counts = counts_of(values);
  ColoredPoints points;
  points.colors =
      colors_by(values, [&](double value) { return styles[static_cast<std::uint8_t>(value)].color; });
  for (std::size_t number = 0; number < counts.size(); ++number) {
    if (counts[number] == 0) continue;
    const ClassStyle& style = styles[number];
    points.key.swatches.push_back({style.color, std::to_string(number), style.name, counts[number]});
  }
  return points;
}

ColoredPoints by_returns(const PointColoring& coloring, const PointValues& values) {
  const ValueExtent extent = extent_of(values);
  const ColorMap map = coloring.map.value_or(usual_map(coloring.by));
  const ValueRange range = coloring.range.value_or(extent.range);
  const auto color_of = [&](double value) { return to_color16(map_color(map, place_in(range, value))); };
  const std::array<std::uint64_t, 256> counts = counts_of(values);
  ColoredPoints points;
  points.colors = colors_by(values, color_of);
  for (std::size_t number = 0; number < counts.size(); ++number) {
    if (counts[number] == 0) continue;
    points.key.swatches.push_back(
        {color_of(static_cast<double>(number)), std::to_string(number), {}, counts[number]});
  }
  points.key.missing_count = values.count - extent.count;
  return points;
}

/// The six directions of the world's axes.
ColoredPoints by_normal() {
  ColoredPoints points;
  const auto add = [&](const glm::dvec3& normal, const char* label) {
    points.key.swatches.push_back({.color = to_color16(0.5 + 0.5 * normal), .label = label});
  };
  add({0.0, 0.0, 1.0}, "up (+z)");
  add({0.0, 0.0, -1.0}, "down (\u2212z)");
  add({1.0, 0.0, 0.0}, "east (+x)");
  add({-1.0, 0.0, 0.0}, "west (\u2212x)");
  add({0.0, 1.0, 0.0}, "north (+y)");
  add({0.0, -1.0, 0.0}, "south (\u2212y)");
  return points;
}

ColoredPoints colored(const PointColoring& coloring, const AttributeColumns& columns, const TreeView& tree) {
  if (coloring.by == PointColor::rgb) return {};
  if (coloring.by == PointColor::normal) return by_normal();
  // A cloud without points needs no columns.
  const PointValues values = tree.point_count == 0 ? heights(tree) : values_of(coloring, columns, tree);
  switch (coloring.by) {
    case PointColor::classification:
      return by_class(coloring, values);
    case PointColor::return_number:
    case PointColor::number_of_returns:
      return by_returns(coloring, values);
    default:
      return by_scale(coloring, values);
  }
}

}  // namespace

ColoredPoints color_points(const PointColoring& coloring, const AttributeColumns& columns,
                           const PointCloud& facts, const TreeView& tree) {
  ColoredPoints points = colored(coloring, columns, tree);
  points.key.by = coloring.by;
  points.key.point_count = tree.point_count;
  describe(coloring, facts, points.key);
  return points;
}

}  // namespace alidade
