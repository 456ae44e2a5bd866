// SPDX-License-Identifier: MIT
#include "visibility/observers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace alidade::test {

using namespace visibility;

namespace {

const Bounds k_extent{.min = {100, 200, 0}, .max = {130, 220, 9}};

std::optional<double> slope(const glm::dvec2& position) {
  return position.x;
}

TEST(ObserverGrid, has_the_middles_of_cells_that_cover_the_extent) {
  const auto grid = observer_grid(k_extent, 10.0, slope);
  ASSERT_EQ(grid.size(), 6u);
  EXPECT_EQ(grid[0].position, glm::dvec2(105, 205));
  EXPECT_FALSE(grid[0].z) << "it is on the ground";
  EXPECT_EQ(grid[0].name, "1-1");
  EXPECT_EQ(grid[5].position, glm::dvec2(125, 215));
  EXPECT_EQ(grid[5].name, "2-3");
}

TEST(ObserverGrid, shares_its_middle_with_an_extent_of_odd_size) {
  const auto grid = observer_grid(k_extent, 20.0, slope);
  ASSERT_EQ(grid.size(), 2u);
  EXPECT_EQ(grid[0].position, glm::dvec2(105, 210));
  EXPECT_EQ(grid[1].position, glm::dvec2(125, 210));
}

TEST(ObserverGrid, leaves_out_positions_without_ground) {
  const auto grid = observer_grid(k_extent, 10.0, [](const glm::dvec2& position) -> std::optional<double> {
    return position.x < 110.0 ? std::optional(3.0) : std::nullopt;
  });
  ASSERT_EQ(grid.size(), 2u);
  EXPECT_EQ(grid[1].name, "2-1");
  EXPECT_THROW(observer_grid(k_extent, 10.0, [](const glm::dvec2&) { return std::optional<double>(); }),
               Error);
}

TEST(ObserverGrid, of_a_single_position_has_one_cell) {
  const Bounds single{.min = {1, 2, 3}, .max = {1, 2, 3}};
  const auto grid = observer_grid(single, 5.0, slope);
  ASSERT_EQ(grid.size(), 1u);
  EXPECT_EQ(grid[0].position, glm::dvec2(1, 2));
}

TEST(ObserverGrid, rejects_no_width_and_too_many_positions) {
  for (const double width : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_THROW(observer_grid(k_extent, width, slope), Error);
  EXPECT_THROW(observer_grid(k_extent, 1e-3, slope), Error);
}

}  // namespace
}  // namespace alidade::test
