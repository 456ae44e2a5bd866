// SPDX-License-Identifier: MIT
#include "image/choose_color.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/json.h"
#include "cloud/cloud_inputs.h"
#include "image/point_values.h"

namespace alidade {
namespace {

struct ColorAttribute {
  std::string_view word;
  Attribute attribute;
};

/// Words that stand for one of the standard columns.
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
  throw Error({.file = name,
               .problem = fmt::format("points have no \"{}\" to be coloured by{}", word,
                                      nearest.empty() ? "" : fmt::format(", did you mean \"{}\"?", nearest)),
               .expected = fmt::format("one of {}", fmt::join(words, ", "))});
}

bool has_color(const AttributeColumns& columns) {
  return std::any_of(columns.colors.begin(), columns.colors.end(),
                     [](const Color16& color) { return color != Color16(0); });
}

bool has_varied_intensity(const AttributeColumns& columns) {
  return std::any_of(columns.intensities.begin(), columns.intensities.end(),
                     [&](std::uint16_t value) { return value != columns.intensities.front(); });
}

PointColor automatic_color(const AttributeColumns& columns, const std::string& name,
                           std::vector<std::string>& warnings) {
  if (has_color(columns)) return PointColor::rgb;
  const bool varied = has_varied_intensity(columns);
  warnings.push_back(name + (columns.colors.empty() ? " has no colour" : " has only black as colour") +
                     (varied ? ": coloured by intensity" : " and no varied intensity: coloured by height"));
  return varied ? PointColor::intensity : PointColor::height;
}

/// Wishes that would change nothing are mistakes.
void check_use(const PointColoring& coloring, const std::string& name) {
  const bool no_numbers = coloring.by == PointColor::rgb || coloring.by == PointColor::normal ||
                          coloring.by == PointColor::classification;
  if (no_numbers && (coloring.map || coloring.range)) {
    throw Error({.file = name,
                 .problem = "a colour map or range is for points coloured by numbers",
                 .expected = "height, intensity, gps_time or another attribute",
                 .found = color_word(coloring)});
  }
  if (coloring.by != PointColor::classification && !coloring.classes.empty()) {
    throw Error({.file = name,
                 .problem = "colours of classes are for points coloured by class",
                 .expected = "classification",
                 .found = color_word(coloring)});
  }
}

}  // namespace

AttributeSet attributes_for(const PointColoring& coloring) {
  switch (coloring.by) {
    case PointColor::automatic:
      return Attribute::color | Attribute::intensity;
    case PointColor::height:
    case PointColor::normal:
      return {};
    default:
      return standard_attribute(color_word(coloring)).value_or(Attribute::extra_dimensions);
  }
}

AttributeSet check_color_of_files(const PointColoring& coloring, std::span<const std::filesystem::path> files,
                                  Damage damage, const std::string& name) {
  const AttributeSet needed = attributes_for(coloring);
  AttributeSet seen;
  if (coloring.by == PointColor::automatic || needed == AttributeSet()) return seen;
  for (const std::filesystem::path& file : files) {
    seen = seen | open_cloud(cloud_input(file), damage)->attributes();
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

}  // namespace alidade
