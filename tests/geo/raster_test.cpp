// SPDX-License-Identifier: MIT
#include "geo/raster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/huge_memory.h"

namespace alidade::test {

using namespace geo;

namespace {

Bounds area(double x0, double y0, double x1, double y1) {
  return {{x0, y0, 0.0}, {x1, y1, 0.0}};
}

std::string rejection(const Bounds& of, double cell_size) {
  try {
    grid_over(of, cell_size);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(RasterGridTest, covers_the_area_on_multiples_of_the_cell_size) {
  const RasterGrid grid = grid_over(area(690000.3, 5325001.0, 690010.0, 5325003.9), 2.0);
  EXPECT_EQ(grid.north_west, glm::dvec2(690000, 5325004));
  EXPECT_EQ(grid.columns, 5);
  EXPECT_EQ(grid.rows, 2);
  EXPECT_EQ(grid.south_east(), glm::dvec2(690010, 5325000));
}

TEST(RasterGridTest, row_zero_is_the_northernmost_and_values_apply_to_whole_cells) {
  const RasterGrid grid = grid_over(area(0, 0, 30, 20), 10.0);
  EXPECT_EQ(grid.center(0, 0), glm::dvec2(5, 15));
  EXPECT_EQ(grid.center(2, 1), glm::dvec2(25, 5));
  EXPECT_EQ(cell_at(grid, {5, 15}), glm::ivec2(0, 0));
  EXPECT_EQ(cell_at(grid, {29, 1}), glm::ivec2(2, 1));
}

TEST(RasterGridTest, edges_belong_to_the_east_and_south_and_outer_edges_to_the_outermost_cell) {
  const RasterGrid grid = grid_over(area(0, 0, 30, 20), 10.0);
  EXPECT_EQ(cell_at(grid, {10, 10}), glm::ivec2(1, 1));
  EXPECT_EQ(cell_at(grid, {30, 0}), glm::ivec2(2, 1));
  EXPECT_EQ(cell_at(grid, {30.001, 0}), std::nullopt);
  EXPECT_EQ(cell_at(grid, {std::numeric_limits<double>::quiet_NaN(), 0}), std::nullopt);
}

TEST(RasterGridTest, a_single_position_is_a_map_of_one_cell) {
  const RasterGrid grid = grid_over(area(7, 7, 7, 7), 2.0);
  EXPECT_EQ(grid.size(), 1u);
  EXPECT_TRUE(cell_at(grid, {7, 7}));
}

TEST(RasterGridTest, too_many_cells_are_rejected_with_their_number) {
  EXPECT_EQ(
      rejection(area(0, 0, 100000, 50000), 1.0),
      "map too large; expected at most 2147483648 cells: use larger cells or a smaller area, found 100000 "
      "x 50000 = 5e+09 cells of 1");
  EXPECT_EQ(rejection(area(0, 0, 65536, 32768), 1.0), "");
  EXPECT_NE(rejection(area(0, 0, 4e9, 0), 1.0), "");
}

TEST(RasterGridTest, bad_areas_and_cell_sizes_are_errors) {
  EXPECT_NE(rejection(area(0, 0, 1, 1), 0.0), "");
  EXPECT_NE(rejection(area(0, 0, 1, 1), -1.0), "");
  EXPECT_NE(rejection(area(0, 0, 1, 1), std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_NE(rejection(area(1, 0, 0, 1), 1.0), "");
  EXPECT_NE(rejection(area(0, 0, std::numeric_limits<double>::infinity(), 1), 1.0), "");
  EXPECT_NE(rejection(area(1e15, 0, 1e15 + 1, 1), 1e-3), "");
}

TEST(RasterGridTest, areas_are_cropped_to_what_they_share) {
  EXPECT_EQ(cropped(area(0, 0, 10, 10), area(5, -5, 20, 5)).min, glm::dvec3(5, 0, 0));
  EXPECT_TRUE(cropped(area(0, 0, 10, 10), area(11, 0, 12, 10)).empty());
}

TEST(RasterGridTest, more_memory_than_there_is_is_rejected) {
  EXPECT_NO_THROW(check_memory(1, "a test"));
  EXPECT_THROW(check_memory(std::numeric_limits<std::uint64_t>::max(), "a test"), Error);
}

TEST(RasterGrid, a_part_keeps_the_cells_of_the_grid) {
  const RasterGrid grid{{690000.0, 5325000.0}, 0.1, 50, 40};
  EXPECT_EQ(area_of(grid).min, glm::dvec3(690000.0, 5324996.0, 0.0));
  EXPECT_EQ(area_of(grid).max, glm::dvec3(690005.0, 5325000.0, 0.0));
  EXPECT_EQ(part_over(grid, area_of(grid)), grid);
  const RasterGrid part = part_over(grid, {{690001.05, 5324997.0, 0}, {690002.0, 5324998.01, 0}});
  EXPECT_EQ(part.columns, 10);
  EXPECT_EQ(part.rows, 11);
  EXPECT_NEAR(part.north_west.x, 690001.0, 1e-8);
  EXPECT_NEAR(part.north_west.y, 5324998.1, 1e-8);
  const RasterGrid beyond = part_over(grid, {{689000, 5324999.99, 0}, {690000.01, 5326000, 0}});
  EXPECT_EQ(beyond.columns, 1);
  EXPECT_EQ(beyond.rows, 1);
  EXPECT_EQ(beyond.north_west, grid.north_west);
}

}  // namespace
}  // namespace alidade::test
