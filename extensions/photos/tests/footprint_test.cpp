// SPDX-License-Identifier: MIT
#include "extensions/photos/footprint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/random.h"

namespace alidade::test {
namespace {

using namespace visibility;

/// Cells of side 2 with the south-west corner at (100, 200); rows from the north, # marked.
struct Cells {
  geo::RasterGrid grid;
  std::vector<std::uint8_t> marked;

  explicit Cells(const std::vector<std::string>& rows) {
    grid = {.north_west = {100.0, 200.0 + 2.0 * static_cast<double>(rows.size())},
            .cell_size = 2.0,
            .columns = static_cast<int>(rows[0].size()),
            .rows = static_cast<int>(rows.size())};
    for (const std::string& row : rows)
      for (const char cell : row) marked.push_back(cell == '#');
  }
};

std::vector<PlanePolygon> outline_of(const std::vector<std::string>& rows) {
  const Cells cells(rows);
  return outline(cells.grid, cells.marked);
}

/// Positive counter-clockwise.
double area_of(const std::vector<glm::dvec2>& ring) {
  double area = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const glm::dvec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    area += 0.5 * (a.x * b.y - b.x * a.y);
  }
  return area;
}

TEST(Footprint, one_cell_is_a_square_counter_clockwise) {
  const auto polygons = outline_of({"...", ".#.", "..."});
  ASSERT_EQ(polygons.size(), 1u);
  ASSERT_EQ(polygons[0].rings.size(), 1u);
  const std::vector<glm::dvec2> square = {{102, 202}, {104, 202}, {104, 204}, {102, 204}};
  EXPECT_EQ(polygons[0].rings[0], square);
}

TEST(Footprint, corners_are_only_where_it_turns) {
  const auto polygons = outline_of({"###", "#..", "#.."});
  ASSERT_EQ(polygons.size(), 1u);
  EXPECT_EQ(polygons[0].rings[0].size(), 6u);
  EXPECT_EQ(area_of(polygons[0].rings[0]), 4.0 * 5);
}

TEST(Footprint, holes_run_clockwise_behind_the_outline) {
  const auto polygons = outline_of({"#####", "#.#.#", "#####"});
  ASSERT_EQ(polygons.size(), 1u);
  ASSERT_EQ(polygons[0].rings.size(), 3u);
  EXPECT_EQ(area_of(polygons[0].rings[0]), 4.0 * 15);
  EXPECT_EQ(area_of(polygons[0].rings[1]), -4.0);
  EXPECT_EQ(area_of(polygons[0].rings[2]), -4.0);
}

TEST(Footprint, cells_that_touch_at_a_corner_are_two_polygons) {
  EXPECT_EQ(outline_of({"#.", ".#"}).size(), 2u);
  EXPECT_EQ(outline_of({".#", "#."}).size(), 2u);
}

TEST(Footprint, a_ring_that_touches_itself_becomes_outline_and_hole) {
  const auto polygons = outline_of({"###", "#.#", "##."});
  ASSERT_EQ(polygons.size(), 1u);
  ASSERT_EQ(polygons[0].rings.size(), 2u) << "the hole touches the outline at a corner";
  EXPECT_EQ(area_of(polygons[0].rings[0]), 4.0 * 8);
  EXPECT_EQ(area_of(polygons[0].rings[1]), -4.0);
}

TEST(Footprint, an_island_in_a_hole_is_a_polygon_of_its_own) {
  const auto polygons = outline_of({"#####", "#...#", "#.#.#", "#...#", "#####"});
  ASSERT_EQ(polygons.size(), 2u);
  EXPECT_EQ(polygons[0].rings.size(), 2u);
  EXPECT_EQ(polygons[1].rings.size(), 1u);
}

TEST(Footprint, nothing_marked_is_nothing) {
  EXPECT_TRUE(outline_of({"..", ".."}).empty());
}

TEST(Footprint, areas_of_random_cells_add_up_and_rings_visit_no_corner_twice) {
  Random random;
  for (int round = 0; round < 50; ++round) {
    geo::RasterGrid grid{.north_west = {0, 17}, .cell_size = 1.0, .columns = 23, .rows = 17};
    std::vector<std::uint8_t> marked(grid.size());
    double count = 0.0;
    for (std::uint8_t& cell : marked) count += cell = random.unit() < 0.1 + 0.016 * round;
    double area = 0.0;
    for (const PlanePolygon& polygon : outline(grid, marked)) {
      ASSERT_FALSE(polygon.rings.empty());
      for (std::size_t i = 0; i < polygon.rings.size(); ++i) {
        const auto& ring = polygon.rings[i];
        ASSERT_EQ(area_of(ring) > 0.0, i == 0);
        area += area_of(ring);
        for (std::size_t a = 0; a < ring.size(); ++a)
          for (std::size_t b = a + 1; b < ring.size(); ++b) ASSERT_NE(ring[a], ring[b]);
      }
    }
    ASSERT_EQ(area, count);
  }
}

TEST(Footprint, cells_follow_the_spacing_and_are_not_too_many) {
  const Bounds area{{0, 0, 0}, {100, 50, 9}};
  EXPECT_DOUBLE_EQ(footprint_cell(area, 0.2), 0.5);
  EXPECT_DOUBLE_EQ(footprint_cell(area, 0.05), 0.1);
  EXPECT_DOUBLE_EQ(footprint_cell(area, 1e-6), 0.1) << "2^20 cells";
  EXPECT_DOUBLE_EQ(footprint_cell(area, 0.6), 2.0);
}

}  // namespace
}  // namespace alidade::test
