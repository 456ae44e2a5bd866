// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/attributes.h"
#include "image/color_map.h"

// How the points of a cloud are coloured, as plain data.

namespace alidade::image {

/// Which of a point's values becomes its colour.
enum class PointColor {
  automatic,          ///< rgb if the cloud has it, else several classes, else height: choose_color()
  rgb,                ///< the colours in the file
  intensity,          ///< 0 .. 65535
  height,             ///< world z
  classification,     ///< one colour per ASPRS class
  normal,             ///< the way the surface faces: 0.5 + 0.5 n, n the shading normal towards the viewer
  gps_time,           ///< seconds
  return_number,      ///< which echo of its pulse the point is
  number_of_returns,  ///< how many echoes its pulse had
  attribute,          ///< any other numeric column, by its name
};

/// A word for a PointColor in scene files and on command lines; any other word names an attribute.
struct NamedPointColor {
  std::string_view name;
  PointColor color;
};

inline constexpr std::array<NamedPointColor, 9> k_point_colors = {
    {{"automatic", PointColor::automatic},
     {"rgb", PointColor::rgb},
     {"intensity", PointColor::intensity},
     {"height", PointColor::height},
     {"classification", PointColor::classification},
     {"normal", PointColor::normal},
     {"gps_time", PointColor::gps_time},
     {"return_number", PointColor::return_number},
     {"number_of_returns", PointColor::number_of_returns}}};

/// From low to high, both included.
struct ValueRange {
  double low = 0.0, high = 0.0;

  /// Where a value lies on a scale: 0 at the low end, 1 at the high one; 0.5 if they are equal.
  double share(double value) const { return high > low ? (value - low) / (high - low) : 0.5; }
  bool operator==(const ValueRange&) const = default;
};

/// A class with another colour or name than the usual ones.
struct ClassColor {
  std::uint8_t number = 0;
  Color16 color{0};    ///< display-referred
  std::string name{};  ///< empty: the usual one
};

/// The values that points are coloured by, and the colours of numbers.
struct PointColoring {
  PointColor by = PointColor::automatic;
  std::string attribute{};            ///< its name; only for PointColor::attribute
  std::optional<ColorMap> map{};      ///< empty: grey for intensity, terrain for height, else viridis
  std::optional<ValueRange> range{};  ///< values of the first and last colour; empty: by percentiles
  ValueRange percentiles{1.0, 99.0};  ///< 0 .. 100; numbers of returns are always shown whole
  std::vector<ClassColor> classes{};  ///< each class at most once
};

/// Largest magnitude of values that are shown; larger ones count as no value, as NaN does.
inline constexpr double k_largest_value = 1e300;

/// The coloring by a word of k_point_colors, or else by the attribute of that name. Other settings by
/// default.
PointColoring coloring_by(std::string_view word);

/// The word of k_point_colors for a coloring, or the name of its attribute.
std::string color_word(const PointColoring& coloring);

/// "#rrggbb", hexadecimal, display-referred; empty for anything else.
std::optional<Color16> parse_hex_color(std::string_view text);

/// A colour for a number whose size has no meaning: neighbouring numbers lie far apart in hue (steps of the
/// golden section) and differ in brightness.
Color16 distinct_color(std::uint64_t number);

/// Name and colour of one class.
struct ClassStyle {
  std::string name;
  Color16 color{0};  ///< display-referred
};

/// All 256 classes: names of LAS 1.4 R15, table 17 (point formats 6 to 10); 8 and 12, reserved there, as in
/// the formats before; "Reserved N" to 63, "User class N" from 64. Colours are the customary ones: ground
/// brown, vegetation from light to dark green, buildings red, water blue, wires yellow. Reserved and user
/// classes have colours of their own; no two of the 256 are equal. `changed` overrides all that.
std::array<ClassStyle, 256> class_styles(std::span<const ClassColor> changed = {});

}  // namespace alidade::image
