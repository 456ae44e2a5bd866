// SPDX-License-Identifier: MIT
#include "compare/change_regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <queue>
#include <string>
#include <vector>

#include "base/error.h"
#include "tests/compare/drawn_images.h"

namespace alidade::test {

using namespace compare;

namespace {

/// A map from characters: '.' is 0, digits are tenths.
std::vector<float> map_of(const std::vector<std::string>& rows) {
  std::vector<float> map;
  for (const std::string& row : rows) {
    for (const char character : row)
      map.push_back(character == '.' ? 0.0f : static_cast<float>(character - '0') / 10.0f);
  }
  return map;
}

constexpr ChangeOptions k_every_pixel{.threshold = 0.05, .least_density = 0.0, .gap = 0, .least_pixels = 1};

TEST(ChangeRegions, have_box_size_strength_and_the_position_of_the_strongest_pixel) {
  const std::vector<float> map = map_of({"..........",  //
                                         "..12......",  //
                                         "...9...5..",  //
                                         "..49......",  //
                                         ".........."});
  const ChangeRegions changes = change_regions(map, 10, {}, k_every_pixel);
  ASSERT_EQ(changes.regions.size(), 2u);
  const ChangeRegion& region = changes.regions[0];
  EXPECT_EQ((std::vector{region.left, region.top, region.right, region.bottom}), (std::vector{2, 1, 4, 4}));
  EXPECT_EQ(region.pixels, 5u);
  EXPECT_FLOAT_EQ(static_cast<float>(region.strongest), 0.9f);
  EXPECT_EQ(region.x, 3);
  EXPECT_EQ(region.y, 2);
  EXPECT_NEAR(region.mean, 0.5, 1e-7);
  EXPECT_EQ(changes.regions[1].pixels, 1u);
  EXPECT_EQ(changes.changed_pixels, 6u);
  EXPECT_EQ(changes.small_regions + changes.further_regions, 0u);
  EXPECT_EQ(changes.labels[12], 1u);
  EXPECT_EQ(changes.labels[27], 2u);
  EXPECT_EQ(std::ranges::count(changes.labels, 0u), 44);
}

TEST(ChangeRegions, pixels_that_touch_at_corners_hang_together) {
  const std::vector<float> map = map_of({"1...1",  //
                                         ".1.1.",  //
                                         "..1..",  //
                                         "....."});
  const ChangeRegions changes = change_regions(map, 5, {}, k_every_pixel);
  ASSERT_EQ(changes.regions.size(), 1u);
  EXPECT_EQ(changes.regions[0].pixels, 5u);
}

TEST(ChangeRegions, are_listed_by_size_and_then_in_reading_order) {
  const std::vector<float> map = map_of({"..1...",  //
                                         "1...11",  //
                                         "......",  //
                                         "11....", "......", "111..."});
  const ChangeRegions changes = change_regions(map, 6, {}, k_every_pixel);
  ASSERT_EQ(changes.regions.size(), 5u);
  const std::vector<std::pair<int, int>> positions = {{0, 5}, {4, 1}, {0, 3}, {2, 0}, {0, 1}};
  for (std::size_t i = 0; i < positions.size(); ++i) {
    EXPECT_EQ(changes.regions[i].left, positions[i].first) << i;
    EXPECT_EQ(changes.regions[i].top, positions[i].second) << i;
  }
}

TEST(ChangeRegions, gaps_are_closed_and_their_pixels_do_not_count) {
  const std::vector<float> map = map_of({"..............",  //
                                         ".11..11....11.",  //
                                         ".............."});
  ChangeOptions options = k_every_pixel;
  EXPECT_EQ(change_regions(map, 14, {}, options).regions.size(), 3u);
  options.gap = 1;
  const ChangeRegions changes = change_regions(map, 14, {}, options);
  ASSERT_EQ(changes.regions.size(), 2u);
  EXPECT_EQ(changes.regions[0].pixels, 4u);
  EXPECT_EQ(changes.regions[0].right, 7);
  EXPECT_EQ(changes.labels[14 + 3], 0u);
  options.gap = 2;
  EXPECT_EQ(change_regions(map, 14, {}, options).regions.size(), 1u);
}

TEST(ChangeRegions, scattered_pixels_are_dropped_and_corners_of_squares_are_not) {
  // Every fifth pixel is grain, and there is a square of 6 x 6, a line of 2 pixels and one of 1.
  constexpr int k_side = 60;
  std::vector<float> map(k_side * k_side, 0.0f);
  for (std::size_t i = 0; i < map.size(); i += 5) map[i] = i / k_side % 2 == 0 ? 1.0f : 0.0f;
  const auto clear_and_fill = [&](int left, int top, int width, int height) {
    for (int y = top - 4; y < top + height + 4; ++y) {
      for (int x = left - 4; x < left + width + 4; ++x) {
        const bool is_inside = x >= left && x < left + width && y >= top && y < top + height;
        map[static_cast<std::size_t>(y * k_side + x)] = is_inside ? 1.0f : 0.0f;
      }
    }
  };
  clear_and_fill(10, 10, 6, 6);
  clear_and_fill(30, 10, 20, 2);
  clear_and_fill(30, 30, 20, 1);
  const ChangeRegions changes = change_regions(map, k_side, {}, {.threshold = 0.5, .least_pixels = 1});
  ASSERT_EQ(changes.regions.size(), 2u);
  EXPECT_GE(changes.regions[0].pixels, 36u);
  EXPECT_EQ(changes.regions[1].pixels, 36u);
  EXPECT_GT(changes.changed_pixels, 300u);
}

TEST(ChangeRegions, small_ones_and_those_beyond_the_most_are_counted_and_left_out) {
  const std::vector<float> map = map_of({"1.11.111.11.1"});
  ChangeOptions options = k_every_pixel;
  options.least_pixels = 2;
  options.most_regions = 2;
  const ChangeRegions changes = change_regions(map, 13, {}, options);
  ASSERT_EQ(changes.regions.size(), 2u);
  EXPECT_EQ(changes.regions[0].left, 5);
  EXPECT_EQ(changes.regions[1].left, 2);
  EXPECT_EQ(changes.small_regions, 2u);
  EXPECT_EQ(changes.further_regions, 1u);
  EXPECT_EQ(changes.listed_pixels, 5u);
  EXPECT_EQ(changes.changed_pixels, 9u);
  EXPECT_EQ(std::ranges::count(changes.labels, 0u), 8);
}

TEST(ChangeRegions, the_threshold_itself_is_no_change_and_negative_values_count_by_magnitude) {
  const std::vector<float> map = {0.25f, -0.25f, 0.0f, -0.5f, 0.0f, 0.26f};
  const ChangeRegions changes =
      change_regions(map, 6, {}, {.threshold = 0.25, .least_density = 0.0, .gap = 0, .least_pixels = 1});
  ASSERT_EQ(changes.regions.size(), 2u);
  EXPECT_EQ(changes.regions[0].strongest, 0.5);
  EXPECT_EQ(changes.regions[0].left, 3);
}

TEST(ChangeRegions, infinite_values_have_changed_and_not_a_number_has_not) {
  constexpr float k_infinite = std::numeric_limits<float>::infinity();
  const std::vector<float> map = {1.0f, -k_infinite, std::numeric_limits<float>::quiet_NaN(), 3.0f};
  const ChangeRegions changes =
      change_regions(map, 4, {}, {.threshold = 0.5, .least_density = 0.0, .gap = 0, .least_pixels = 1});
  ASSERT_EQ(changes.regions.size(), 2u);
  EXPECT_EQ(changes.regions[0].pixels, 2u);
  EXPECT_EQ(changes.regions[0].strongest, INFINITY);
  EXPECT_EQ(changes.regions[0].x, 1);
  EXPECT_EQ(changes.regions[0].mean, 1.0);
}

TEST(ChangeRegions, what_the_mask_leaves_out_has_not_changed) {
  const std::vector<float> map = map_of({"11111"});
  const ChangeRegions changes = change_regions(map, 5, {{1, 1, 0, 1, 0}}, k_every_pixel);
  ASSERT_EQ(changes.regions.size(), 2u);
  EXPECT_EQ(changes.changed_pixels, 3u);
}

TEST(ChangeRegions, equal_images_have_none) {
  const ChangeRegions changes = change_regions(std::vector<float>(100, 0.0f), 10, {}, k_every_pixel);
  EXPECT_TRUE(changes.regions.empty());
  EXPECT_EQ(changes.changed_pixels, 0u);
  EXPECT_TRUE(change_regions({}, 10, {}, k_every_pixel).regions.empty());
}

TEST(ChangeRegions, options_out_of_range_are_errors) {
  const std::vector<float> map(4, 0.0f);
  EXPECT_THROW(change_regions(map, 2, {}, {.threshold = -0.1}), Error);
  EXPECT_THROW(change_regions(map, 2, {}, {.threshold = NAN}), Error);
  EXPECT_THROW(change_regions(map, 2, {}, {.least_density = -0.1}), Error);
  EXPECT_THROW(change_regions(map, 2, {}, {.least_density = 1.1}), Error);
  EXPECT_THROW(change_regions(map, 2, {}, {.gap = -1}), Error);
  EXPECT_THROW(change_regions(map, 2, {}, {.gap = 65}), Error);
}

/// Sizes of the parts by flood fill through `closed`, largest first: the definition.
std::vector<std::uint64_t> flooded_sizes(const std::vector<std::uint8_t>& changed,
                                         const std::vector<std::uint8_t>& closed, int width) {
  const int height = static_cast<int>(changed.size()) / width;
  std::vector<std::uint8_t> done(changed.size(), 0);
  std::vector<std::uint64_t> sizes;
  for (int start = 0; start < static_cast<int>(changed.size()); ++start) {
    if (closed[static_cast<std::size_t>(start)] == 0 || done[static_cast<std::size_t>(start)] != 0) continue;
    std::uint64_t size = 0;
    std::queue<int> queue({start});
    done[static_cast<std::size_t>(start)] = 1;
    for (; !queue.empty(); queue.pop()) {
      const int x = queue.front() % width, y = queue.front() / width;
      size += changed[static_cast<std::size_t>(queue.front())];
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
          const auto beside = static_cast<std::size_t>(v * width + u);
          if (closed[beside] == 0 || done[beside] != 0) continue;
          done[beside] = 1;
          queue.push(v * width + u);
        }
      }
    }
    sizes.push_back(size);
  }
  std::ranges::sort(sizes, std::greater<>{});
  return sizes;
}

/// The closing by its definition.
std::vector<std::uint8_t> closed_slowly(const std::vector<std::uint8_t>& set, int width, int gap) {
  const int height = static_cast<int>(set.size()) / width;
  const auto window = [&](const std::vector<std::uint8_t>& from, int pixel, bool any) {
    const int x = pixel % width, y = pixel / width;
    for (int v = std::max(y - gap, 0); v <= std::min(y + gap, height - 1); ++v) {
      for (int u = std::max(x - gap, 0); u <= std::min(x + gap, width - 1); ++u) {
        if ((from[static_cast<std::size_t>(v * width + u)] != 0) == any) return any;
      }
    }
    return !any;
  };
  std::vector<std::uint8_t> grown(set.size()), result(set.size());
  for (int i = 0; i < static_cast<int>(set.size()); ++i)
    grown[static_cast<std::size_t>(i)] = window(set, i, true);
  for (int i = 0; i < static_cast<int>(set.size()); ++i)
    result[static_cast<std::size_t>(i)] = window(grown, i, false);
  return result;
}

TEST(ChangeRegions, of_random_maps_are_those_of_a_flood_fill) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const int width = 1 + static_cast<int>(hashed(4 * seed) * 40),
              height = 1 + static_cast<int>(hashed(4 * seed + 1) * 40);
    const double share = 0.02 + 0.6 * hashed(4 * seed + 2);
    const int gap = static_cast<int>(seed % 5);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << width << " x " << height << ", gap "
                                    << gap);
    std::vector<float> map(static_cast<std::size_t>(width * height));
    std::vector<std::uint8_t> changed(map.size());
    for (std::size_t i = 0; i < map.size(); ++i) {
      map[i] = hashed(1000 * seed + i + 77) < share ? 1.0f : 0.0f;
      changed[i] = map[i] > 0.5f;
    }
    const std::vector<std::uint8_t> closed = closed_slowly(changed, width, gap);
    ASSERT_EQ(close_gaps(changed, width, gap), closed);
    const ChangeRegions changes = change_regions(
        map, width, {},
        {.threshold = 0.5, .least_density = 0.0, .gap = gap, .least_pixels = 1, .most_regions = 10000});
    std::vector<std::uint64_t> sizes, counted(changes.regions.size(), 0);
    for (const ChangeRegion& region : changes.regions) sizes.push_back(region.pixels);
    EXPECT_EQ(sizes, flooded_sizes(changed, closed, width));
    for (std::size_t i = 0; i < map.size(); ++i) {
      ASSERT_EQ(changes.labels[i] != 0, changed[i] != 0);
      if (changed[i] != 0) ++counted[changes.labels[i] - 1];
    }
    EXPECT_EQ(counted, sizes);
  }
}

}  // namespace
}  // namespace alidade::test
