// SPDX-License-Identifier: MIT
#include "tools/render/color_options.h"

#include <algorithm>
#include <sstream>

#include "image/color_key.h"
#include "tools/options.h"

namespace alidade {
namespace {

std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text + separator);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

ValueRange parse_range(const std::string& text, double least, double most) {
  const std::vector<std::string> ends = parts_of(text, ',');
  if (ends.size() != 2) throw CLI::ValidationError("expected two numbers, found '" + text + "'");
  const ValueRange range{parse_number(ends[0], least, most), parse_number(ends[1], least, most)};
  if (!(range.low < range.high))
    throw CLI::ValidationError("expected the smaller number first, found '" + text + "'");
  return range;
}

std::vector<ClassColor> parse_classes(const std::string& text) {
  std::vector<ClassColor> classes;
  for (const std::string& part : parts_of(text, ',')) {
    const std::size_t sign = part.find('=');
    const std::optional<Color16> color =
        sign == std::string::npos ? std::nullopt : parse_hex_color(part.substr(sign + 1));
    if (!color) throw CLI::ValidationError("expected CLASS=#rrggbb, found '" + part + "'");
    classes.push_back({static_cast<std::uint8_t>(parse_count(part.substr(0, sign), 0, 255)), *color});
  }
  return classes;
}

std::filesystem::path parse_legend(const std::string& text) {
  const std::filesystem::path file(text);
  if (file.extension() != ".png" && file.extension() != ".PNG")
    throw CLI::ValidationError("expected a name ending in .png, found '" + text + "'");
  return file;
}

ImageSize parse_legend_size(const std::string& text) {
  // Margins and a line of the smallest type take more than this, whatever the legend says.
  constexpr int k_least_side = 24;
  const ImageSize size = parse_image_size(text);
  if (size.width < k_least_side || size.height < k_least_side) {
    throw CLI::ValidationError("expected at least " + std::to_string(k_least_side) +
                               " pixels each way, found '" + text + "'");
  }
  return size;
}

std::vector<std::pair<std::string, std::optional<ColorMap>>> map_words() {
  std::vector<std::pair<std::string, std::optional<ColorMap>>> words{{"auto", std::nullopt}};
  for (const NamedColorMap& known : k_color_maps) words.emplace_back(known.name, known.map);
  return words;
}

}  // namespace

void add_color_options(CLI::App& command, ColorRequest& request) {
  add_value(command, "--color-by,--color", "NAME",
            "what colours the points: rgb, intensity, height, classification, normal, gps_time, "
            "return_number, number_of_returns, or another attribute by its name (default: rgb, else "
            "intensity, else height)",
            [&request](const std::string& text) {
              if (text.empty()) throw CLI::ValidationError("expected a name, found ''");
              request.by = text;
            });
  add_choice<std::optional<ColorMap>>(
      command, "--color-map",
      "colours of numbers (default auto: grey for intensity, terrain for height, else viridis)", request.map,
      map_words());
  CLI::Option* const range = add_value(command, "--color-range", "MIN,MAX",
                                       "values of the first and last colour (default: by percentiles)",
                                       [&request](const std::string& text) {
                                         request.range = parse_range(text, -k_largest_value, k_largest_value);
                                       });
  add_value(command, "--color-percentiles", "LOW,HIGH",
            "percentiles of the values that the colours span (default 1,99)",
            [&request](const std::string& text) { request.percentiles = parse_range(text, 0.0, 100.0); })
      ->excludes(range);
  add_value(command, "--class-color", "CLASS=#RRGGBB,...",
            "other colours for single classes of --color-by classification",
            [&request](const std::string& text) { request.classes = parse_classes(text); });
  CLI::Option* const legend =
      add_value(command, "--legend", "FILE.png",
                "also write what the colours mean: a colour bar, or the classes with their numbers of points",
                [&request](const std::string& text) { request.legend = parse_legend(text); });
  add_value(command, "--legend-size", "WIDTHxHEIGHT",
            "size of the legend in pixels (default: as its texts need)",
            [&request](const std::string& text) {
              const ImageSize size = parse_legend_size(text);
              request.legend_size = glm::ivec2(size.width, size.height);
            })
      ->needs(legend);
}

std::string given_option(const ColorRequest& request) {
  if (request.by) return "--color-by";
  if (request.map) return "--color-map";
  if (request.range) return "--color-range";
  if (request.percentiles) return "--color-percentiles";
  if (!request.classes.empty()) return "--class-color";
  return request.legend.empty() ? "" : "--legend";
}

void apply(const ColorRequest& request, PointColoring& coloring) {
  if (request.by && *request.by != color_word(coloring)) coloring = coloring_by(*request.by);
  if (request.map) coloring.map = *request.map;
  if (request.range) coloring.range = request.range;
  if (request.percentiles) {
    coloring.percentiles = *request.percentiles;
    coloring.range.reset();
  }
  for (const ClassColor& change : request.classes) {
    const auto known = std::ranges::find(coloring.classes, change.number, &ClassColor::number);
    if (known == coloring.classes.end())
      coloring.classes.push_back(change);
    else
      known->color = change.color;
  }
  if (!request.legend.empty() && coloring.by == PointColor::rgb) check_legend({.by = PointColor::rgb});
}

}  // namespace alidade
