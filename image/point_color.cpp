// SPDX-License-Identifier: MIT
#include "image/point_color.h"

#include <algorithm>
#include <charconv>

namespace alidade {

PointColoring coloring_by(std::string_view word) {
  const auto known = std::ranges::find(k_point_colors, word, &NamedPointColor::name);
  if (known != k_point_colors.end()) return {.by = known->color};
  return {.by = PointColor::attribute, .attribute = std::string(word)};
}

std::string color_word(const PointColoring& coloring) {
  const auto known = std::ranges::find(k_point_colors, coloring.by, &NamedPointColor::color);
  return known != k_point_colors.end() ? std::string(known->name) : coloring.attribute;
}

std::optional<Color16> parse_hex_color(std::string_view text) {
  constexpr std::size_t k_length = 7;
  if (text.size() != k_length || text[0] != '#') return std::nullopt;
  Color16 color;
  for (int channel = 0; channel < 3; ++channel) {
    const char* const begin = text.data() + 1 + 2 * channel;
    std::uint8_t value = 0;
    const auto [end, error] = std::from_chars(begin, begin + 2, value, 16);
    if (error != std::errc() || end != begin + 2) return std::nullopt;
    color[channel] = static_cast<std::uint16_t>(257 * value);
  }
  return color;
}

}  // namespace alidade
