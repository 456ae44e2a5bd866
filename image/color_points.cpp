// SPDX-License-Identifier: MIT
#include "image/color_points.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <map>

#include "base/shown_text.h"
#include "base/words.h"
#include "cloud/axis_units.h"
#include "cloud/cloud_reader.h"

namespace alidade::image {
namespace {

constexpr std::int64_t k_day = 24 * 60 * 60;
constexpr std::int64_t k_adjustment = 1'000'000'000;
/// Millions of years on either side, within which nothing overflows.
constexpr std::int64_t k_most_seconds = std::int64_t{1} << 46;

std::string time_of_day(std::int64_t second) {
  return fmt::format("{:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60);
}

struct ColorAttribute {
  std::string_view word;
  Attribute attribute;
};

/// Words that represent one of the standard columns.
constexpr std::array<ColorAttribute, 11> k_color_attributes = {
    {{"rgb", Attribute::color},
     {"intensity", Attribute::intensity},
     {"classification", Attribute::classification},
     {"gps_time", Attribute::gps_time},
     {"return_number", Attribute::returns},
     {"number_of_returns", Attribute::returns},
     {"near_infrared", Attribute::near_infrared},
     {"flags", Attribute::flags},
     {"scan_angle", Attribute::scan_angle},
     {"user_data", Attribute::user_data},
     {"point_source_id", Attribute::point_source_id}}};

std::optional<Attribute> standard_attribute(std::string_view word) {
  const auto known = std::ranges::find(k_color_attributes, word, &ColorAttribute::word);
  if (known == k_color_attributes.end()) return std::nullopt;
  return known->attribute;
}

bool has_column(const AttributeColumns& columns, const std::string& word) {
  if (const auto attribute = standard_attribute(word)) return columns.attributes().contains(*attribute);
  return find_numbers(columns, word) != nullptr;
}

[[noreturn]] void fail(const std::string& name, const std::string& word, AttributeSet present,
                       const std::vector<ExtraColumn>& extra_columns) {
  std::vector<std::string_view> words = {"height", "normal"};
  for (const ColorAttribute& known : k_color_attributes) {
    if (present.contains(known.attribute)) words.push_back(known.word);
  }
  for (const ExtraColumn& column : extra_columns) {
    if (has_numbers(column)) words.push_back(column.description.name);
  }
  const std::string_view nearest = nearest_word(word, words);
  throw file_error(name,
                   fmt::format("the cloud has no attribute \"{}\"{}", word,
                               nearest.empty() ? "" : fmt::format(", did you mean \"{}\"?", nearest)),
                   fmt::format("one of {}", fmt::join(words, ", ")));
}

bool has_color(const AttributeColumns& columns) {
  return std::ranges::any_of(columns.colors, [](const Color16& color) { return color != Color16(0); });
}

/// Whether half of the points or more have a class other than unclassified and noise, and there are several
/// classes: one alone shows nothing.
bool is_classified(const AttributeColumns& columns) {
  std::array<std::size_t, 256> counts{};
  for (const std::uint8_t number : columns.classifications) ++counts[number];
  std::size_t kinds = 0, meant = 0;
  for (std::size_t number = 0; number < counts.size(); ++number) {
    kinds += counts[number] > 0 ? 1 : 0;
    if (number > 1 && number != 7 && number != 18) meant += counts[number];
  }
  return kinds >= 2 && 2 * meant >= columns.classifications.size();
}

PointColor automatic_color(const AttributeColumns& columns, const std::string& name,
                           std::vector<std::string>& warnings) {
  if (has_color(columns)) return PointColor::rgb;
  const PointColor by = is_classified(columns) ? PointColor::classification : PointColor::height;
  warnings.push_back(name + (columns.colors.empty() ? " has no colours" : " has only black colours") +
                     ": coloured by " + color_word({.by = by}) +
                     "; --legend FILE.png writes what the colours mean");
  return by;
}

/// Errors: settings that have no effect on this coloring.
void check_use(const PointColoring& coloring, const std::string& name) {
  const bool no_numbers = coloring.by == PointColor::rgb || coloring.by == PointColor::normal ||
                          coloring.by == PointColor::classification;
  if (no_numbers && (coloring.map || coloring.range)) {
    throw file_error(name, "a colour map or range requires a numeric attribute",
                     "height, intensity, gps_time or another attribute", color_word(coloring));
  }
  if (coloring.by != PointColor::classification && !coloring.classes.empty())
    throw file_error(name, "class colours require classification", {}, color_word(coloring));
}

ColorMap usual_map(PointColor by) {
  if (by == PointColor::intensity) return ColorMap::grey;
  return by == PointColor::height ? ColorMap::terrain : ColorMap::viridis;
}

/// "point_source_id" -> "Point source id".
std::string title_of(const std::string& word) {
  std::string title = line_text(word);
  std::ranges::replace(title, '_', ' ');
  if (!title.empty() && title[0] >= 'a' && title[0] <= 'z')
    title[0] = static_cast<char>(title[0] - 'a' + 'A');
  return title;
}

/// The kind of clock in words, and its time at the labels' 0.
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

/// Sets the title, its unit, and the origin of ticks.
void describe(const PointColoring& coloring, const PointCloud& facts, ColorKey& key) {
  key.word = color_word(coloring);
  key.title = title_of(key.word);
  if (key.by == PointColor::height) key.unit = height_unit_label(facts.crs);
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

/// color_of(value) for every point that has a value.
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
  points.colors = colors_by(values, [&](double value) {
    return to_color16(map_color(scale.map, position_in(scale.range, value)));
  });
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
  const auto color_of = [&](double value) { return to_color16(map_color(map, position_in(range, value))); };
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

/// One of the few values of a column, and how it is shown.
struct ValueCategory {
  double value = 0.0;
  Swatch swatch{};
};

/// More different values than this are shown along a scale.
constexpr std::size_t k_most_categories = 24;

/// Values and how many points have them; `fits` turns false as soon as they are too many, or not whole
/// numbers from 0 on.
struct ValueCounts {
  std::map<double, std::uint64_t> counts{};
  bool fits = true;

  void add(double value, std::uint64_t count) {
    constexpr double k_largest_whole = 0x1p53;
    if (!fits || std::isnan(value)) return;
    fits = value >= 0.0 && value <= k_largest_whole && value == std::floor(value);
    if (fits) counts[value] += count;
    fits = fits && counts.size() <= k_most_categories;
  }
};

ValueCounts value_counts(const PointValues& values) {
  tbb::enumerable_thread_specific<ValueCounts> of_threads;
  values.for_each_block([&](const ValueBlock& block) {
    ValueCounts& counts = of_threads.local();
    for (const double value : block.values) {
      if (!counts.fits) return;
      counts.add(value, 1);
    }
  });
  ValueCounts sums;
  for (const ValueCounts& each : of_threads) {
    sums.fits = sums.fits && each.fits;
    for (const auto& [value, count] : each.counts) sums.add(value, count);
  }
  return sums;
}

std::string label_of_mask(std::uint64_t mask) {
  std::vector<int> bits;
  for (int bit = 0; bit < 64; ++bit)
    if (mask >> bit & 1) bits.push_back(bit + 1);
  if (bits.empty()) return "none";
  return fmt::format("{}", fmt::join(bits, ", "));
}

/// The different values of a column of numbers, in ascending order, with a colour each; empty if there are
/// more than k_most_categories, or a value is not a whole number from 0 to 2^53. Numbers that count up from 0
/// or 1 have colours along `map`, others (flight lines, objects) and masks those of distinct_color(), a
/// mask without bits grey. The labels of masks list the bits that are set, the lowest being 1. NaN values are
/// ignored. Cost: one pass, in parallel.
std::vector<ValueCategory> categories_of(const PointValues& values, ColorMap map, bool are_masks) {
  const ValueCounts found = value_counts(values);
  if (!found.fits || found.counts.empty()) return {};
  const double low = found.counts.begin()->first, high = found.counts.rbegin()->first;
  const bool counts_up =
      !are_masks && low <= 1.0 && high - low + 1.0 == static_cast<double>(found.counts.size());
  std::vector<ValueCategory> categories;
  for (const auto& [value, count] : found.counts) {
    const auto number = static_cast<std::uint64_t>(value);
    constexpr Color16 k_no_bit{0xb8b8};  // a light grey
    const Color16 color = are_masks && number == 0 ? k_no_bit
                          : counts_up ? to_color16(map_color(map, position_in({low, high}, value)))
                                      : distinct_color(are_masks ? categories.size() : number);
    categories.push_back({value,
                          {.color = color,
                           .number = are_masks ? "" : std::to_string(number),
                           .label = are_masks ? label_of_mask(number) : "",
                           .count = count}});
  }
  return categories;
}

/// How many bits are set in each whole number; of values that are whole numbers from 0 to 2^64.
PointValues bit_counts(const PointValues& masks) {
  return {masks.count, [masks](const VisitBlock& visit) {
            masks.for_each_block([&](const ValueBlock& block) {
              std::vector<double> counts(block.values.begin(), block.values.end());
              for (double& value : counts)
                if (value >= 0.0 && value < 0x1p64) value = std::popcount(static_cast<std::uint64_t>(value));
              visit({counts, block.first_id, block.ids});
            });
          }};
}

/// Whether each bit of an extra dimension has a meaning by its description, as in VisibleBy of 'visibility
/// points'.
bool has_masks(const AttributeColumns& columns, const std::string& name) {
  const ExtraColumn* const column = find_numbers(columns, name);
  return column != nullptr && column->description.description.starts_with("bit ");
}

/// Few whole numbers that are not measurements are shown one by one, unless a map or a range is given.
ColoredPoints by_attribute(const PointColoring& coloring, const AttributeColumns& columns,
                           const PointValues& values) {
  const bool is_measure = coloring.attribute == "near_infrared" || coloring.attribute == "scan_angle";
  if (is_measure || coloring.map || coloring.range) return by_scale(coloring, values);
  const bool are_masks = has_masks(columns, coloring.attribute);
  const std::vector<ValueCategory> categories = categories_of(values, usual_map(coloring.by), are_masks);
  if (categories.empty()) return by_scale(coloring, are_masks ? bit_counts(values) : values);
  ColoredPoints points;
  points.colors = colors_by(values, [&](double value) {
    return std::ranges::lower_bound(categories, value, {}, &ValueCategory::value)->swatch.color;
  });
  points.key.missing_count = values.count;
  for (const ValueCategory& category : categories) {
    points.key.missing_count -= *category.swatch.count;
    points.key.swatches.push_back(category.swatch);
  }
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

ColoredPoints colored(const PointColoring& coloring, const AttributeColumns& columns,
                      const PointValues& heights) {
  if (coloring.by == PointColor::rgb) return {};
  if (coloring.by == PointColor::normal) return by_normal();
  // A cloud without points needs no columns.
  const PointValues values = heights.count == 0 ? heights : values_of(coloring, columns, heights);
  switch (coloring.by) {
    case PointColor::classification:
      return by_class(coloring, values);
    case PointColor::return_number:
    case PointColor::number_of_returns:
      return by_returns(coloring, values);
    case PointColor::attribute:
      return by_attribute(coloring, columns, values);
    default:
      return by_scale(coloring, values);
  }
}

}  // namespace

std::optional<std::string> gps_date(std::int64_t adjusted_seconds) {
  using namespace std::chrono;
  if (adjusted_seconds < -k_most_seconds || adjusted_seconds > k_most_seconds) return std::nullopt;
  constexpr sys_days k_epoch = year(1980) / January / 6;
  const std::int64_t since_1970 =
      duration_cast<seconds>(k_epoch.time_since_epoch()).count() + k_adjustment + adjusted_seconds;
  const std::int64_t day_count = since_1970 >= 0 ? since_1970 / k_day : (since_1970 - k_day + 1) / k_day;
  constexpr sys_days k_first = year(1) / January / 1, k_last = year(9999) / December / 31;
  if (day_count < k_first.time_since_epoch().count() || day_count > k_last.time_since_epoch().count())
    return std::nullopt;
  const year_month_day date{sys_days(days(day_count))};
  return fmt::format("{:04}-{:02}-{:02} {}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     time_of_day(since_1970 - day_count * k_day));
}

std::optional<std::string> gps_weekday(std::int64_t week_seconds) {
  constexpr std::array<const char*, 7> k_days = {"Sunday",   "Monday", "Tuesday", "Wednesday",
                                                 "Thursday", "Friday", "Saturday"};
  if (week_seconds < 0 || week_seconds >= 7 * k_day) return std::nullopt;
  return fmt::format("{} {}", k_days[static_cast<std::size_t>(week_seconds / k_day)],
                     time_of_day(week_seconds % k_day));
}

AttributeSet attributes_for(const PointColoring& coloring) {
  switch (coloring.by) {
    case PointColor::automatic:
      return Attribute::color | Attribute::classification;
    case PointColor::height:
    case PointColor::normal:
      return {};
    default:
      return standard_attribute(color_word(coloring)).value_or(Attribute::extra_dimensions);
  }
}

AttributeSet check_color_of_files(const PointColoring& coloring, const CloudInputs& inputs, Damage damage,
                                  const std::string& name) {
  const AttributeSet needed = attributes_for(coloring);
  AttributeSet seen;
  if (coloring.by == PointColor::automatic || needed == AttributeSet()) return seen;
  for (const CloudInput& input : inputs.inputs) {
    seen = seen | open_cloud(input, damage)->facts().attributes;
    if ((seen & needed) == needed) return seen;
  }
  fail(name, color_word(coloring), seen, {});
}

PointColoring choose_color(const PointColoring& coloring, const ColorSource& cloud,
                           std::vector<std::string>& warnings) {
  const AttributeColumns& columns = cloud.columns;
  PointColoring chosen = coloring;
  if (coloring.by == PointColor::automatic)
    chosen.by = cloud.point_count == 0 ? PointColor::rgb : automatic_color(columns, cloud.name, warnings);
  check_use(chosen, cloud.name);
  const bool needs_column = attributes_for(chosen) != AttributeSet();
  if (cloud.point_count > 0 && needs_column && !has_column(columns, color_word(chosen)))
    fail(cloud.name, color_word(chosen), cloud.attributes | columns.attributes(), columns.extra_dimensions);
  return chosen;
}

ColoredPoints color_points(const PointColoring& coloring, const AttributeColumns& columns,
                           const PointCloud& facts, const PointValues& heights) {
  ColoredPoints points = colored(coloring, columns, heights);
  points.key.by = coloring.by;
  points.key.point_count = heights.count;
  describe(coloring, facts, points.key);
  return points;
}

}  // namespace alidade::image
