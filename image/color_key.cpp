// SPDX-License-Identifier: MIT
#include "image/color_key.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace alidade::image {
namespace {

std::string with_unit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : text + " " + unit;
}

}  // namespace

std::string range_text(const ValueRange& range, double origin) {
  const double low = range.low - origin, high = range.high - origin;
  const double extent = high - low, largest = std::max(std::fabs(low), std::fabs(high));
  int digits = 6;
  for (double step = 1e-6 * largest; digits < 15 && step > 1e-4 * extent; step /= 10.0) ++digits;
  return fmt::format("{:.{}g} to {:.{}g}", low, digits, high, digits);
}

std::string title_text(const ColorKey& key) {
  return key.unit.empty() ? key.title : fmt::format("{} ({})", key.title, key.unit);
}

std::string scale_text(const ColorKey& key) {
  if (!key.scale) return "";
  const ColorScale& scale = *key.scale;
  const std::string chosen = scale.percentiles ? fmt::format("percentiles {:g} to {:g}; ",
                                                             scale.percentiles->low, scale.percentiles->high)
                                               : "";
  std::string text = fmt::format("{} ({}all {})", with_unit(range_text(scale.range, scale.origin), key.unit),
                                 chosen, with_unit(range_text(scale.extent, scale.origin), key.unit));
  if (!scale.origin_text.empty()) text += "; " + scale.origin_text;
  return fmt::format("{}, colour map {}", text, name(scale.map));
}

std::vector<std::pair<std::string, std::string>> color_metadata(const ColorKey& key) {
  std::vector<std::pair<std::string, std::string>> texts{{"alidade:color_by", key.word}};
  if (!key.scale) return texts;
  texts.emplace_back("alidade:color_map", name(key.scale->map));
  texts.emplace_back("alidade:color_range",
                     fmt::format("{:.17g} {:.17g}", key.scale->range.low, key.scale->range.high));
  return texts;
}

void check_legend(const ColorKey& key) {
  if (key.by == PointColor::rgb) {
    throw input_error("rgb colours have no legend",
                      "colours by height, intensity, classification or another attribute", "rgb");
  }
  if (key.by != PointColor::normal && key.point_count == key.missing_count)
    throw Error({.problem = "empty legend: no point has a value of " + key.word});
}

}  // namespace alidade::image
