// SPDX-License-Identifier: MIT
#include "visibility/raster/map_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "base/error.h"
#include "image/font.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace visibility;

namespace {

constexpr Rgb8 k_north_color{200, 100, 0}, k_south_color{0, 60, 120}, k_mark_color{220, 30, 40};
constexpr float k_nothing = std::numeric_limits<float>::quiet_NaN();

/// 10 x 6 cells of 5; the ground rises by this in x and y.
RasterGrid grid() {
  return {{1000, 2000}, 5.0, 10, 6};
}
Ground ground(const glm::dvec2& slope = {0.0, 0.0}) {
  Raster<double> heights(grid(), 0.0);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 10; ++column) {
      const glm::dvec2 position = grid().center(column, row);
      heights.at(column, row) = slope.x * (position.x - 1000) + slope.y * (position.y - 2000);
    }
  }
  return Ground(heights, 10.0, GroundSource::lowest, grid().size());
}

/// 1 in the three northern rows, 0 in the southern ones.
MapImage image() {
  MapImage map{.title = "Test",
               .values = Raster<float>(grid(), 0.0f),
               .swatches = {{1.0f, k_north_color, "north"}, {0.0f, k_south_color, "south"}},
               .unit = "m"};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 10; ++column) map.values.at(column, row) = 1.0f;
  }
  return map;
}

struct Found {
  int count = 0;
  double row = 0.0, column = 0.0;  ///< mean
};

/// Pixels of a colour on the map of 100 x 60 pixels, left of the legend.
Found find_color(const Canvas& canvas, const Rgb8& color) {
  constexpr int k_right = 24 + 100;
  Found found;
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < k_right; ++x) {
      if (canvas.at(x, y) != color) continue;
      ++found.count;
      found.row += y;
      found.column += x;
    }
  }
  found.row /= std::max(found.count, 1);
  found.column /= std::max(found.count, 1);
  return found;
}

Canvas draw(const MapImage& map, const Ground& of = ground()) {
  return draw_map(map, of, Font(find_font()), 100);
}

TEST(MapImageTest, cells_have_their_colours_and_north_is_up) {
  const Canvas canvas = draw(image());
  const Found north = find_color(canvas, k_north_color), south = find_color(canvas, k_south_color);
  EXPECT_EQ(north.count, 100 * 30);
  EXPECT_EQ(south.count, 100 * 30);
  EXPECT_NEAR(south.row - north.row, 30.0, 1e-9);
}

TEST(MapImageTest, values_without_a_swatch_have_colours_of_the_scale) {
  MapImage map = image();
  map.swatches.pop_back();
  map.scale = {ColorMap::viridis, {0.0, 2.0}, "value"};
  const Canvas canvas = draw(map);
  EXPECT_EQ(find_color(canvas, k_north_color).count, 100 * 30);
  const glm::dvec3 lowest = map_color(ColorMap::viridis, 0.0);
  const auto code = [](double value) { return static_cast<std::uint8_t>(std::lround(255.0 * value)); };
  EXPECT_EQ(find_color(canvas, {code(lowest.r), code(lowest.g), code(lowest.b)}).count, 100 * 30);
}

TEST(MapImageTest, nothing_is_drawn_where_there_is_no_value) {
  MapImage map = image();
  for (int column = 0; column < 10; ++column) map.values.at(column, 0) = k_nothing;
  EXPECT_EQ(find_color(draw(map), k_north_color).count, 100 * 20);
}

TEST(MapImageTest, observers_are_marked_at_their_position_unless_they_are_outside) {
  MapImage map = image();
  map.marks = {{{1025, 1985}, ""}, {{1200, 1985}, "far away"}};
  const Found mark = find_color(draw(map), k_mark_color);
  EXPECT_GT(mark.count, 50);
  EXPECT_LT(mark.count, 150);
  EXPECT_NEAR(mark.column, 24 + 50, 1.0);
}

TEST(MapImageTest, large_maps_are_drawn_smaller_and_small_ones_in_whole_pixels_per_cell) {
  MapImage map{.title = "T", .values = Raster<float>({{0, 0}, 1.0, 1000, 20}, 1.0f)};
  map.swatches = {{1.0f, k_north_color, "seen"}};
  EXPECT_EQ(find_color(draw(map), k_north_color).count, 100 * 2);
  map.values = Raster<float>({{0, 0}, 1.0, 30, 30}, 1.0f);
  EXPECT_EQ(find_color(draw(map), k_north_color).count, 90 * 90);
  map.values = Raster<float>({{0, 0}, 1.0, 1, 1}, 1.0f);
  EXPECT_EQ(find_color(draw(map), k_north_color).count, 100 * 100);
}

TEST(MapImageTest, the_same_map_gives_the_same_pixels) {
  const Ground slope = ground({0.1, -0.2});
  EXPECT_TRUE(draw(image(), slope).bytes() == draw(image(), slope).bytes());
}

TEST(MapImageTest, the_file_appears_completely_or_not_at_all) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "alidade_map_picture";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  write_map_image(image(), ground(), folder / "map.png", false);
  EXPECT_THROW(write_map_image(image(), ground(), folder / "map.png", false), Error);
  EXPECT_THROW(write_map_image(image(), ground(), folder / "map.gif", false), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "map.gif"));
  std::string magic(4, ' ');
  std::ifstream(folder / "map.png", std::ios::binary).read(magic.data(), 4);
  EXPECT_EQ(magic, "\x89PNG");
  std::filesystem::remove_all(folder);
}

TEST(ReliefTest, slopes_towards_the_light_are_bright_and_level_ground_is_as_it_is) {
  const glm::dvec2 middle(1025, 1985);
  EXPECT_EQ(Relief(ground(), 5.0).light(middle), 1.0);
  // Ground that rises to the south-east looks north-west, to where the light comes from.
  EXPECT_GT(Relief(ground({0.1, -0.1}), 5.0).light(middle), 1.1);
  EXPECT_LT(Relief(ground({-0.1, 0.1}), 5.0).light(middle), 0.8);
  EXPECT_EQ(Relief(ground(), 5.0).light({5000, 5000}), 1.0);
}

}  // namespace
}  // namespace alidade::test
