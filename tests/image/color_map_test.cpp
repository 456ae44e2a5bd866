// SPDX-License-Identifier: MIT
#include "image/color_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>

#include "base/color.h"
#include "image/point_color.h"

namespace alidade {

using namespace image;

namespace {

/// CIE L* of a display-referred colour. Source: CIE 15, with the luminance of IEC 61966-2-1.
double lightness(const glm::dvec3& display) {
  const double luminance = 0.2126 * linear_from_srgb(display.r) + 0.7152 * linear_from_srgb(display.g) +
                           0.0722 * linear_from_srgb(display.b);
  return luminance > 0.008856 ? 116.0 * std::cbrt(luminance) - 16.0 : 903.3 * luminance;
}

void expect_near(const glm::dvec3& found, const glm::dvec3& expected, double error) {
  for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(found[channel], expected[channel], error);
}

TEST(ColorMapTest, published_colours_are_met_to_five_thousandths) {
  // Entries 0, 64, 128, 192 and 255 of the published tables of 256.
  expect_near(map_color(ColorMap::viridis, 0.0), {0.267004, 0.004874, 0.329415}, 0.005);
  expect_near(map_color(ColorMap::viridis, 64.0 / 255), {0.229739, 0.322361, 0.545706}, 0.005);
  expect_near(map_color(ColorMap::viridis, 128.0 / 255), {0.127568, 0.566949, 0.550556}, 0.005);
  expect_near(map_color(ColorMap::viridis, 192.0 / 255), {0.369214, 0.788888, 0.382914}, 0.005);
  expect_near(map_color(ColorMap::viridis, 1.0), {0.993248, 0.906157, 0.143936}, 0.005);
  expect_near(map_color(ColorMap::turbo, 0.0), {0.18995, 0.07176, 0.23217}, 0.005);
  expect_near(map_color(ColorMap::turbo, 128.0 / 255), {0.64362, 0.98999, 0.23356}, 0.005);
  expect_near(map_color(ColorMap::turbo, 1.0), {0.47960, 0.01583, 0.01055}, 0.005);
  expect_near(map_color(ColorMap::inferno, 0.0), {0.001462, 0.000466, 0.013866}, 0.005);
  expect_near(map_color(ColorMap::inferno, 128.0 / 255), {0.735683, 0.215906, 0.330245}, 0.005);
  expect_near(map_color(ColorMap::inferno, 1.0), {0.988362, 0.998364, 0.644924}, 0.005);
}

TEST(ColorMapTest, lightness_of_viridis_inferno_and_grey_never_falls) {
  for (const ColorMap map : {ColorMap::viridis, ColorMap::inferno, ColorMap::grey}) {
    double before = -1.0;
    for (int i = 0; i <= 4000; ++i) {
      const double here = lightness(map_color(map, i / 4000.0));
      ASSERT_GT(here, before) << name(map) << " at " << i;
      before = here;
    }
  }
}

TEST(ColorMapTest, lightness_of_viridis_grows_in_even_steps) {
  const double low = lightness(map_color(ColorMap::viridis, 0.0)),
               high = lightness(map_color(ColorMap::viridis, 1.0));
  for (int i = 0; i <= 100; ++i) {
    const double even = low + (high - low) * i / 100.0;
    EXPECT_NEAR(lightness(map_color(ColorMap::viridis, i / 100.0)), even, 2.0) << i;
  }
}

TEST(ColorMapTest, positions_outside_are_the_nearest_end_and_nan_is_the_low_one) {
  for (const NamedColorMap& each : k_color_maps) {
    const glm::dvec3 low = map_color(each.map, 0.0), high = map_color(each.map, 1.0);
    EXPECT_EQ(map_color(each.map, -0.5), low);
    EXPECT_EQ(map_color(each.map, -INFINITY), low);
    EXPECT_EQ(map_color(each.map, NAN), low);
    EXPECT_EQ(map_color(each.map, 1.5), high);
    EXPECT_EQ(map_color(each.map, INFINITY), high);
    EXPECT_NE(low, high);
    EXPECT_EQ(name(each.map), each.name);
  }
}

TEST(ColorMapTest, colours_between_are_linear_between_even_steps) {
  EXPECT_EQ(map_color(ColorMap::grey, 0.5), glm::dvec3(0.5 * 0.2 + 0.5 * 0.95));
  EXPECT_EQ(map_color(ColorMap::terrain, 0.25), glm::dvec3(0.60, 0.68, 0.42));
  const glm::dvec3 middle = map_color(ColorMap::terrain, 0.125);
  expect_near(middle, {0.45, 0.565, 0.38}, 1e-12);
}

TEST(ColorMapTest, display_values_are_rounded_to_the_nearest_of_65536) {
  EXPECT_EQ(to_color16({0.0, 0.5, 1.0}), Color16(0, 32768, 65535));
  EXPECT_EQ(to_color16({0.4 / 65535, 0.6 / 65535, 65534.6 / 65535}), Color16(0, 1, 65535));
}

TEST(ClassificationColorsTest, classes_have_the_names_of_las_1_4) {
  const auto styles = class_styles();
  EXPECT_EQ(styles[2].name, "Ground");
  EXPECT_EQ(styles[6].name, "Building");
  EXPECT_EQ(styles[9].name, "Water");
  EXPECT_EQ(styles[18].name, "High noise");
  EXPECT_EQ(styles[22].name, "Temporal exclusion");
  EXPECT_EQ(styles[23].name, "Reserved 23");
  EXPECT_EQ(styles[63].name, "Reserved 63");
  EXPECT_EQ(styles[64].name, "User class 64");
  EXPECT_EQ(styles[255].name, "User class 255");
}

TEST(ClassificationColorsTest, no_two_of_the_256_colours_are_equal) {
  std::set<std::tuple<int, int, int>> seen;
  for (const ClassStyle& style : class_styles()) {
    // Also not after rounding to 8 bits.
    EXPECT_TRUE(seen.emplace(style.color.r / 257, style.color.g / 257, style.color.b / 257).second)
        << style.name;
  }
}

TEST(ClassificationColorsTest, colours_are_the_customary_ones) {
  const auto styles = class_styles();
  const Color16 ground = styles[2].color, high_vegetation = styles[5].color, building = styles[6].color,
                water = styles[9].color;
  EXPECT_TRUE(ground.r > ground.g && ground.g > ground.b);
  EXPECT_TRUE(high_vegetation.g > high_vegetation.r && high_vegetation.g > high_vegetation.b);
  EXPECT_TRUE(building.r > building.g && building.r > building.b);
  EXPECT_TRUE(water.b > water.g && water.g > water.r);
  const auto light = [&](std::size_t i) { return lightness(glm::dvec3(styles[i].color) / 65535.0); };
  EXPECT_TRUE(light(3) > light(4) && light(4) > light(5));
}

TEST(ClassificationColorsTest, single_classes_can_be_shown_otherwise) {
  const ClassColor changes[] = {{6, Color16(1, 2, 3)}, {64, Color16(4, 5, 6), "Wind turbine"}};
  const auto usual = class_styles(), styles = class_styles(changes);
  EXPECT_EQ(styles[6].color, Color16(1, 2, 3));
  EXPECT_EQ(styles[6].name, "Building");
  EXPECT_EQ(styles[64].color, Color16(4, 5, 6));
  EXPECT_EQ(styles[64].name, "Wind turbine");
  EXPECT_EQ(styles[65].color, usual[65].color);
}

TEST(PointColorTest, words_are_known_ways_to_colour_or_names_of_attributes) {
  for (const NamedPointColor& known : k_point_colors) {
    EXPECT_EQ(coloring_by(known.name).by, known.color);
    EXPECT_EQ(color_word(coloring_by(known.name)), known.name);
  }
  const PointColoring other = coloring_by("Reflectance");
  EXPECT_EQ(other.by, PointColor::attribute);
  EXPECT_EQ(other.attribute, "Reflectance");
  EXPECT_EQ(color_word(other), "Reflectance");
}

TEST(PointColorTest, hexadecimal_colours_have_a_sign_and_six_digits) {
  EXPECT_EQ(parse_hex_color("#ff8000"), Color16(65535, 128 * 257, 0));
  EXPECT_EQ(parse_hex_color("#C83c32"), Color16(200 * 257, 60 * 257, 50 * 257));
  for (const char* const bad : {"", "#", "ff8000", "#ff800", "#ff80000", "#ff80 0", "#-f8000", "#+f8000",
                                "#gg8000", "# f8000", "#0x8000"})
    EXPECT_FALSE(parse_hex_color(bad)) << bad;
}

}  // namespace
}  // namespace alidade
