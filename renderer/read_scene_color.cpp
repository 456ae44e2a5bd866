// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "renderer/read_scene_parts.h"

namespace alidade {
namespace {

ValueRange read_range(const JsonNode& node, const NumberRange& allowed) {
  const std::vector<JsonNode> ends = node.elements(2, 2);
  const ValueRange range{ends[0].number(allowed), ends[1].number(allowed)};
  if (!(range.low < range.high)) node.fail("range is empty", "the smaller number first");
  return range;
}

Color16 read_hex_color(const JsonNode& node) {
  const std::string text = node.text();
  const std::optional<Color16> color = parse_hex_color(text);
  if (!color) node.fail("not a colour", "\"#rrggbb\" in hexadecimal");
  return *color;
}

ClassColor read_class(const JsonNode& node) {
  const JsonFields fields(node, {"class", "color", "name"});
  ClassColor result;
  result.number = static_cast<std::uint8_t>(fields.require("class").whole_number(0, 255));
  result.color = read_hex_color(fields.require("color"));
  if (const auto name = fields.find("name")) result.name = name->text();
  return result;
}

std::vector<ClassColor> read_classes(const JsonNode& node) {
  std::vector<ClassColor> classes;
  for (const JsonNode& each : node.elements(0, 256)) {
    const ClassColor read = read_class(each);
    if (std::ranges::find(classes, read.number, &ClassColor::number) != classes.end())
      each.fail("class stands twice", "every class once");
    classes.push_back(read);
  }
  return classes;
}

}  // namespace

PointColoring read_coloring(const JsonNode& node) {
  if (node.is_string()) return coloring_by(node.text());
  const JsonFields fields(node, {"by", "map", "range", "percentiles", "classes"});
  PointColoring coloring;
  if (const auto by = fields.find("by")) coloring = coloring_by(by->text());
  if (const auto map = fields.find("map")) {
    std::array<std::string_view, k_color_maps.size() + 1> words{"auto"};
    std::ranges::transform(k_color_maps, words.begin() + 1, &NamedColorMap::name);
    if (const std::size_t word = map->choice(words); word > 0) coloring.map = k_color_maps[word - 1].map;
  }
  if (const auto range = fields.find("range")) {
    constexpr std::array<std::string_view, 1> words{"auto"};
    if (range->is_string())
      range->choice(words);
    else
      coloring.range = read_range(*range, {-k_largest_value, k_largest_value});
  }
  if (const auto percentiles = fields.find("percentiles"))
    coloring.percentiles = read_range(*percentiles, {0, 100});
  if (const auto classes = fields.find("classes")) coloring.classes = read_classes(*classes);
  return coloring;
}

}  // namespace alidade
