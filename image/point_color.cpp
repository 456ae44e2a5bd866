// SPDX-License-Identifier: MIT
#include "image/point_color.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/common.hpp>

namespace alidade::image {
namespace {

struct StandardClass {
  std::string_view name;
  std::uint32_t color;  ///< 0xRRGGBB
};

constexpr std::array<StandardClass, 23> k_standard_classes = {{
    {"Never classified", 0xb8b8b8},
    {"Unclassified", 0x9a9a9a},
    {"Ground", 0xa87443},
    {"Low vegetation", 0xb5d96b},
    {"Medium vegetation", 0x6cbf45},
    {"High vegetation", 0x2f7f33},
    {"Building", 0xd8745a},
    {"Low noise", 0xc51f5d},
    {"Model key point", 0x6b4a2b},
    {"Water", 0x3b8fd6},
    {"Rail", 0x8e44ad},
    {"Road surface", 0x5b5f66},
    {"Overlap", 0xc7b2d6},
    {"Wire, guard", 0xf7e463},
    {"Wire, conductor", 0xf2c230},
    {"Transmission tower", 0xe08e0b},
    {"Wire connector", 0xc9a227},
    {"Bridge deck", 0x4f6bc9},
    {"High noise", 0xff5fa2},
    {"Overhead structure", 0x7a5c9e},
    {"Ignored ground", 0xd4b48c},
    {"Snow", 0xe8f1f8},
    {"Temporal exclusion", 0x8c8c6e},
}};

constexpr std::size_t k_first_user_class = 64;

Color16 from_hex(std::uint32_t color) {
  return Color16(color >> 16, color >> 8 & 255u, color & 255u) * std::uint16_t{257};
}

/// Display colour of a hue in [0, 1) with this saturation and value. Source: Smith, Color Gamut Transform
/// Pairs, SIGGRAPH 1978.
glm::dvec3 from_hue(double hue, double saturation, double value) {
  const glm::dvec3 turned = glm::fract(glm::dvec3(hue) + glm::dvec3(1.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0;
  const glm::dvec3 pure = glm::clamp(glm::abs(turned) - 1.0, 0.0, 1.0);
  return value * glm::mix(glm::dvec3(1.0), pure, saturation);
}

}  // namespace

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

Color16 distinct_color(std::uint64_t number) {
  constexpr double k_golden_section = 0.6180339887498949;
  constexpr std::array<double, 3> k_saturations = {0.75, 0.55, 0.40}, k_values = {0.85, 0.62, 0.95};
  const double turns = k_golden_section * static_cast<double>(number);
  return to_color16(from_hue(turns - std::floor(turns), k_saturations[number % 3], k_values[number % 3]));
}

std::array<ClassStyle, 256> class_styles(std::span<const ClassColor> changed) {
  std::array<ClassStyle, 256> styles;
  for (std::size_t number = 0; number < styles.size(); ++number) {
    ClassStyle& style = styles[number];
    if (number < k_standard_classes.size()) {
      style = {std::string(k_standard_classes[number].name), from_hex(k_standard_classes[number].color)};
    } else {
      const char* const kind = number < k_first_user_class ? "Reserved " : "User class ";
      style = {kind + std::to_string(number), distinct_color(number)};
    }
  }
  for (const ClassColor& change : changed) {
    styles[change.number].color = change.color;
    if (!change.name.empty()) styles[change.number].name = change.name;
  }
  return styles;
}

}  // namespace alidade::image
