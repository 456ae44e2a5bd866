// SPDX-License-Identifier: MIT
#include "visibility/raster/viewshed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "tests/visibility/viewshed_place.h"
#include "visibility/raster/map_targets.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

TEST(ViewshedTest, level_ground_is_seen_whole_from_eye_height) {
  for (const double noise : {0.0, 0.01}) {
    Field field(noise);
    const Observer eye = at(-20, 3, 1.7);
    int seen = 0, cells = 0;
    for_cells(field.seen({&eye, 1}), [&](float value, const glm::dvec2&) {
      seen += value == 1.0f;
      ++cells;
    });
    EXPECT_EQ(cells, 28 * 28);
    EXPECT_GE(seen, cells * 995 / 1000) << noise;
  }
}

TEST(ViewshedTest, a_wall_hides_what_lies_in_its_shadow) {
  Field field;
  field.wall(0, -28, 28, 0, 3);
  const Observer eye = at(-10, 0, 6);
  // From 6 high and 10 before a wall of 3, the shadow on the ground ends 10 behind it, where lines are level
  // with the wall's foot and parallel to it.
  for_cells(field.seen({&eye, 1}), [&](float value, const glm::dvec2& cell) {
    const double height_over_wall = 6.0 * (1.0 - 10.0 / (cell.x + 10.0));
    if (cell.x < -1 || height_over_wall > 3.0 + k_edge) {
      EXPECT_EQ(value, 1.0f) << cell.x << " " << cell.y;
    } else if (cell.x > 1 && height_over_wall < 3.0 - k_before_edge && std::fabs(cell.y) < 14) {
      EXPECT_EQ(value, 0.0f) << cell.x << " " << cell.y;
    }
  });
}

TEST(ViewshedTest, what_looks_over_the_wall_is_seen_from_its_height_on) {
  Field field;
  field.wall(0, -28, 28, 0, 3);
  const Observer eye = at(-10, 0, 1.5);
  // The line over the wall's edge rises 1.5 in 10.
  const Viewshed seen = field.seen({&eye, 1}, {.mode = ViewshedMode::height, .highest = 50.0});
  for_cells(seen, [&](float value, const glm::dvec2& cell) {
    if (cell.x < -1) {
      EXPECT_EQ(value, 0.0f) << cell.x << " " << cell.y;
    }
    if (cell.x < 1 || std::fabs(cell.y) > 14) return;
    const double expected = 1.5 + 1.5 * (cell.x + 10.0) / 10.0;
    EXPECT_GE(value, expected - k_before_edge * (cell.x + 10.0) / 10.0) << cell.x << " " << cell.y;
    EXPECT_LE(value, expected + k_edge * (cell.x + 10.0) / 10.0) << cell.x << " " << cell.y;
  });
}

TEST(ViewshedTest, the_height_found_is_seen_and_what_is_a_centimetre_lower_is_not) {
  Field field;
  field.wall(0, -10, 10, 0, 3);
  const Observer eye = at(-10, 0, 1.5);
  const Viewshed seen = field.seen({&eye, 1}, {.mode = ViewshedMode::height, .highest = 50.0});
  int hidden = 0;
  for_cells(seen, [&](float value, const glm::dvec2& cell) {
    if (!(value > 0.0f)) return;
    ++hidden;
    const SightEnd from = end_near_surface(field.occluders(), eye.position);
    const SightEnd foot = end_on_ground(field.occluders(), {cell.x, cell.y, *field.ground().at(cell)});
    EXPECT_FALSE(first_blocker(field.occluders(), sight_line(from, raised(foot, value + 1e-6))));
    EXPECT_TRUE(first_blocker(field.occluders(), sight_line(from, raised(foot, value - 0.0101))));
  });
  EXPECT_GT(hidden, 50);
}

TEST(ViewshedTest, one_sees_below_a_bridge_and_the_lowest_height_is_there) {
  Field field;
  field.sheet({-4, -20, 4}, {8, 0, 0}, {0, 40, 0}, 17);
  const Observer low = at(-20, 0, 1.7), high = at(-20, 0, 20);
  const Viewshed from_below = field.seen({&low, 1}), from_above = field.seen({&high, 1});
  const auto cell = *cell_at(Field::grid(), {3, 1});
  EXPECT_EQ(from_below.values.at(cell.x, cell.y), 1.0f);
  EXPECT_EQ(from_above.values.at(cell.x, cell.y), 0.0f);
  const Viewshed height = field.seen({&low, 1}, {.mode = ViewshedMode::height});
  EXPECT_EQ(height.values.at(cell.x, cell.y), 0.0f);
}

TEST(ViewshedTest, one_sees_through_the_gap_between_points_without_surface_and_the_lowest_height_is_there) {
  // A wire half way: its lowest point hides the ground, the others what is 2.7 to 5.5 above. Its points are
  // as far from each other as would make discs that reach from the one to the others.
  Field field;
  field.point({0, 1, 0.85});
  for (int i = 0; i < 10; ++i) field.point({0, 1, 2.2 + 0.15 * i});
  const Observer eye = at(-11, 1, 1.7);
  const glm::ivec2 cell = *cell_at(Field::grid(), {11, 1});
  EXPECT_EQ(field.seen({&eye, 1}).values.at(cell.x, cell.y), 0.0f);
  EXPECT_EQ(field.seen({&eye, 1}, {.target_height = 4.0}).values.at(cell.x, cell.y), 0.0f);
  const Viewshed height = field.seen({&eye, 1}, {.mode = ViewshedMode::height});
  EXPECT_GT(height.values.at(cell.x, cell.y), 0.1f);
  EXPECT_LT(height.values.at(cell.x, cell.y), 1.5f);
}

TEST(ViewshedTest, what_is_never_seen_has_the_highest_height) {
  Field field;
  field.wall(0, -28, 28, 0, 10);
  const Observer eye = at(-2, 0, 1.0);
  const Viewshed seen = field.seen({&eye, 1}, {.mode = ViewshedMode::height, .highest = 12.0});
  const auto cell = *cell_at(Field::grid(), {21, 1});
  EXPECT_EQ(seen.values.at(cell.x, cell.y), 12.0f);
}

TEST(ViewshedTest, count_is_the_sum_of_single_viewsheds_and_visible_their_union) {
  Field field;
  field.wall(0, -15, 15, 0, 3);
  field.wall(10, -28, 0, 0, 5);
  const std::vector<Observer> eyes{at(-10, 0, 2), at(20, 10, 2), at(5, -20, 8)};
  const Viewshed count = field.seen(eyes, {.mode = ViewshedMode::count}), any = field.seen(eyes);
  Raster<float> sum(Field::grid(), 0.0f);
  for (const Observer& eye : eyes) {
    const Viewshed one = field.seen({&eye, 1});
    for (std::size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += one.values.values[i];
  }
  EXPECT_EQ(count.values.values, sum.values);
  for (std::size_t i = 0; i < sum.values.size(); ++i)
    EXPECT_EQ(any.values.values[i], sum.values[i] > 0.0f ? 1.0f : 0.0f);
  EXPECT_EQ(count.line_count, 3u * sum.values.size());
}

TEST(ViewshedTest, fraction_is_the_share_of_free_lines) {
  Field field;
  field.wall(0, -28, 28, 0, 3);
  const std::vector<Observer> eyes{at(-10, 0, 2), at(-12, 0, 2)};
  const Viewshed seen = field.seen(eyes, {.mode = ViewshedMode::fraction, .positions_across = 4});
  for_cells(seen, [&](float value, const glm::dvec2& cell) {
    // Not where lines cross the foot of the wall, whose points are of no one surface.
    if (cell.x < -1 || cell.x > 6) {
      EXPECT_EQ(value, cell.x < 0 ? 1.0f : 0.0f) << cell.x << ' ' << cell.y;
    }
    EXPECT_EQ(value * 32.0f, std::round(value * 32.0f));
  });
}

TEST(ViewshedTest, cells_beyond_distance_and_field_of_view_are_out_of_range) {
  Field field;
  Observer eye = at(1, 1, 2);
  eye.max_distance = 15.0;
  eye.azimuth_min = 0.0;
  eye.azimuth_max = 90.0;
  for_cells(field.seen({&eye, 1}), [&](float value, const glm::dvec2& cell) {
    const bool within = std::hypot(cell.x - 1, cell.y - 1, 2.0) <= 15.0 && cell.x >= 1 && cell.y >= 1;
    EXPECT_EQ(value, within ? 1.0f : k_out_of_range) << cell.x << " " << cell.y;
  });
}

TEST(ViewshedTest, cells_without_ground_have_no_value) {
  Field field;
  const Observer eye = at(0, 0, 2);
  const Viewshed seen =
      viewshed(field.occluders(), field.ground(), {&eye, 1}, grid_over({{20, 20, 0}, {60, 22, 0}}, 2.0), {});
  EXPECT_EQ(seen.values.at(0, 0), 1.0f);
  EXPECT_TRUE(std::isnan(seen.values.at(19, 0)));
}

TEST(ViewshedTest, heights_begin_where_the_field_of_view_does) {
  // Looking up by 10 degrees and more, an eye over open ground sees a thing as soon as it reaches up there.
  Field field;
  Observer eye = at(0, 0, 2);
  eye.elevation_min = 10.0;
  eye.max_distance = 20.0;
  const double slope = std::tan(10.0 * std::numbers::pi / 180.0);
  const Viewshed seen = field.seen({&eye, 1}, {.mode = ViewshedMode::height, .highest = 4.5});
  int in_view = 0;
  for_cells(seen, [&](float value, const glm::dvec2& cell) {
    const double run = glm::length(cell), lowest = 2.0 + slope * run;
    if (run * std::hypot(1.0, slope) > 19.9 || lowest > 4.49) {
      // The rest of the view lies beyond the distance or above what is tried.
      if (run > 20.1 || lowest > 4.51) {
        EXPECT_EQ(value, k_out_of_range) << cell.x << " " << cell.y;
      }
      return;
    }
    ++in_view;
    EXPECT_NEAR(value, lowest, 1e-3) << cell.x << " " << cell.y;
  });
  EXPECT_GT(in_view, 100);
}

TEST(ViewshedTest, what_is_first_free_above_the_field_of_view_is_not_seen) {
  Field field;
  field.wall(0, -28, 28, 0, 3);
  Observer eye = at(-10, 0, 1.5);
  // The line over the wall's edge rises by 8.5 degrees, and by at most 12 with the discs that stand over it.
  for (const auto& [most, sees] : {std::pair(5.0, false), {15.0, true}}) {
    eye.elevation_max = most;
    const Viewshed seen = field.seen({&eye, 1}, {.mode = ViewshedMode::height, .highest = 50.0});
    const auto cell = *cell_at(Field::grid(), {11, 1});
    const float value = seen.values.at(cell.x, cell.y);
    EXPECT_EQ(value < 50.0f, sees) << most;
    if (sees) {
      EXPECT_LE(value, 1.5 + 21.0 * std::tan(most * std::numbers::pi / 180.0) + 0.1);
    }
  }
}

TEST(ViewshedTest, heights_are_those_at_which_the_plain_map_sees) {
  // With any field of view, the cell is seen at its height, and at none of some below it.
  Field field;
  field.wall(0, -28, 28, 0, 3);
  field.wall(8, -28, 28, 0, 6);
  Observer eye = at(-10, 0, 4);
  eye.elevation_min = -14.0;
  eye.elevation_max = 5.0;
  eye.max_distance = 30.0;
  constexpr double k_highest = 12.0;
  const Viewshed heights = field.seen({&eye, 1}, {.mode = ViewshedMode::height, .highest = k_highest});
  std::vector<Viewshed> maps;
  for (int step = 0; step < 24; ++step) maps.push_back(field.seen({&eye, 1}, {.target_height = 0.5 * step}));
  int visible = 0, never = 0, out_of_range = 0;
  for (std::size_t i = 0; i < heights.values.values.size(); ++i) {
    const float height = heights.values.values[i];
    bool looked_at = false;
    for (int step = 0; step < 24; ++step) {
      const float value = maps[static_cast<std::size_t>(step)].values.values[i];
      looked_at = looked_at || value != k_out_of_range;
      if (height >= 0.0f && 0.5 * step < height - 0.011) {
        EXPECT_LE(value, 0.0f) << i << " at " << 0.5 * step;
      }
    }
    EXPECT_TRUE(!looked_at || height != k_out_of_range) << i;
    visible += height > 0.0f && height < k_highest;
    never += height == k_highest;
    out_of_range += height == k_out_of_range;
  }
  EXPECT_GT(visible, 50);
  EXPECT_GT(never, 20);
  EXPECT_GT(out_of_range, 20);
}

TEST(ViewshedTest, targets_above_the_wall_are_seen) {
  Field field;
  field.wall(0, -28, 28, 0, 3);
  const Observer eye = at(-10, 0, 1.5);
  const auto cell = *cell_at(Field::grid(), {5, 1});
  EXPECT_EQ(field.seen({&eye, 1}, {.target_height = 3.0}).values.at(cell.x, cell.y), 0.0f);
  EXPECT_EQ(field.seen({&eye, 1}, {.target_height = 5.0}).values.at(cell.x, cell.y), 1.0f);
}

TEST(MapTargetsTest, blocks_hold_every_cell_once_and_never_many_positions) {
  Field field;
  const RasterGrid grid = grid_over({{-28, -28, 0}, {28, 28, 0}}, 0.15);
  for (const int across : {1, 7, k_most_positions_across}) {
    const MapTargets targets(field.occluders(), field.ground(), grid, across, std::size_t{1} << 18);
    std::vector<int> found(grid.size(), 0);
    std::size_t most = 0;
    for (std::size_t number = 0; number < targets.block_count(); ++number) {
      const std::vector<std::size_t> cells = targets.cells(number);
      for (const std::size_t cell : cells) ++found[cell];
      most = std::max(most, cells.size() * static_cast<std::size_t>(across * across));
    }
    EXPECT_EQ(std::ranges::count(found, 1), static_cast<std::ptrdiff_t>(grid.size())) << across;
    EXPECT_LE(most, std::size_t{1} << 18) << across;
  }
  const MapBlock block = MapTargets(field.occluders(), field.ground(), grid, 2, 1 << 18).block(0);
  ASSERT_EQ(block.targets.size(), 4 * block.cells.size());
  EXPECT_EQ(block.targets[4 * 17 + 3].cell, 17u);
}

TEST(ViewshedTest, many_positions_of_a_cell_are_those_of_a_map_of_finer_cells) {
  Field field;
  field.wall(0, -28, 28, 0, 3);
  const Observer eye = at(-10, 0, 7);
  const Bounds area{{0, -16, 0}, {16, 0, 0}};
  const RasterGrid coarse = grid_over(area, 16.0), fine = grid_over(area, 0.25);
  const auto share = viewshed(field.occluders(), field.ground(), {&eye, 1}, coarse,
                              {.mode = ViewshedMode::fraction, .positions_across = 64});
  const auto seen = viewshed(field.occluders(), field.ground(), {&eye, 1}, fine, {});
  const auto count = std::ranges::count(seen.values.values, 1.0f);
  EXPECT_GT(count, 0);
  EXPECT_LT(count, 64 * 64);
  EXPECT_EQ(share.values.at(0, 0), static_cast<float>(count) / (64.0f * 64.0f));
}

}  // namespace
}  // namespace alidade::test
