// SPDX-License-Identifier: MIT
#include "cloud/select_points.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "cloud/rows.h"
#include "tests/cloud/chosen_points.h"

namespace alidade {
namespace {

using test::error_of;
using test::expect_same_columns;
using test::full_cloud;
using test::rows_of;

/// From the definition, cube by cube.
PointCloud thinned_by_hand(const PointCloud& cloud, double edge) {
  std::map<std::array<double, 3>, std::vector<std::size_t>> cubes;
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    const glm::dvec3 position = cloud.world(row);
    const auto cube_of = [&](double x) { return std::floor(x / edge + 1e-6); };
    cubes[{cube_of(position.x), cube_of(position.y), cube_of(position.z)}].push_back(row);
  }
  PointCloud changed = cloud;
  std::vector<std::size_t> chosen;
  for (const auto& [cube, rows] : cubes) {
    const auto count = static_cast<long double>(rows.size());
    long double mean[3] = {0, 0, 0};
    for (const std::size_t row : rows) {
      for (int axis = 0; axis < 3; ++axis) mean[axis] += cloud.positions[row][axis] / count;
    }
    std::size_t best = rows.front();
    long double least = -1;
    for (const std::size_t row : rows) {
      long double square = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const long double away =
            (cloud.positions[row][axis] - mean[axis]) * static_cast<long double>(cloud.lattice.scale[axis]);
        square += away * away;
      }
      // Equal ones differ by rounding only.
      if (least < 0 || square < least * (1 - 1e-12L)) {
        least = square;
        best = row;
      }
    }
    const auto rounded_mean = [&, &in = rows](const auto& value) {
      double sum = 0;
      for (const std::size_t row : in) sum += value(row);
      return static_cast<std::uint16_t>(std::floor(sum / static_cast<double>(in.size()) + 0.5));
    };
    for (int channel = 0; channel < 3; ++channel) {
      changed.colors[best][channel] =
          rounded_mean([&, channel](std::size_t row) { return cloud.colors[row][channel]; });
    }
    changed.near_infrared[best] = rounded_mean([&](std::size_t row) { return cloud.near_infrared[row]; });
    changed.intensities[best] = rounded_mean([&](std::size_t row) { return cloud.intensities[row]; });
    chosen.push_back(best);
  }
  std::sort(chosen.begin(), chosen.end());
  return rows_of(changed, chosen);
}

TEST(ThinTest, one_real_point_per_cube_stays_the_nearest_to_the_mean_with_mean_colours) {
  for (const double edge : {0.005, 0.02, 0.05, 0.3, 1.0, 7.0, 1e7}) {
    const PointCloud cloud = full_cloud(5000, 100, 11);
    PointCloud thinned = cloud;
    thin(thinned, edge);
    expect_same_columns(thinned, thinned_by_hand(cloud, edge));
    EXPECT_GT(thinned.size(), 0u);
  }
}

TEST(ThinTest, of_equally_near_points_the_first_stays) {
  PointCloud cloud;
  cloud.positions = {{4, 4, 4}, {6, 6, 6}, {104, 4, 4}, {106, 4, 4}, {104, 6, 4}, {106, 6, 4}};
  cloud.lattice.scale = glm::dvec3(0.1);
  for (int turn = 0; turn < 6; ++turn) {
    PointCloud thinned = cloud;
    thin(thinned, 1.0);
    ASSERT_EQ(thinned.size(), 2u);
    for (const LatticePosition& position : thinned.positions) {
      const auto first =
          std::find_if(cloud.positions.begin(), cloud.positions.end(),
                       [&](const LatticePosition& one) { return one.x / 10 == position.x / 10; });
      EXPECT_EQ(*first, position);
    }
    std::rotate(cloud.positions.begin(), cloud.positions.begin() + 1, cloud.positions.end());
  }
}

TEST(ThinTest, lower_faces_belong_to_a_cube_and_upper_faces_to_its_neighbour) {
  // Steps of a hundredth on a grid of two: pairs all along, however the coordinates round.
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.01), .offset = {690000.0, -20.0, 0.0}};
  for (int i = -10000; i < 10000; ++i) cloud.positions.emplace_back(i, i, i);
  PointCloud thinned = cloud;
  thin(thinned, 0.02);
  ASSERT_EQ(thinned.size(), 10000u);
  for (std::size_t i = 0; i < thinned.size(); ++i) EXPECT_EQ(thinned.positions[i].x & 1, 0);
}

TEST(ThinTest, clouds_thinned_apart_fit_together) {
  const PointCloud cloud = full_cloud(5000, 100, 12);
  std::vector<std::size_t> west, east;
  // 690000 is a multiple of the edge.
  for (std::size_t row = 0; row < cloud.size(); ++row)
    (cloud.positions[row].x < 0 ? west : east).push_back(row);
  PointCloud whole = cloud, left = rows_of(cloud, west), right = rows_of(cloud, east);
  thin(whole, 0.25);
  thin(left, 0.25);
  thin(right, 0.25);
  EXPECT_EQ(whole.size(), left.size() + right.size());
  PointCloud left_of_whole = whole;
  std::vector<std::uint8_t> marks;
  for (const LatticePosition& position : whole.positions) marks.push_back(position.x < 0 ? 1 : 0);
  keep_rows(left_of_whole, marks);
  expect_same_columns(left_of_whole, left);
}

TEST(ThinTest, the_result_does_not_depend_on_the_number_of_threads) {
  const PointCloud cloud = full_cloud(60000, 200, 13);
  PointCloud many = cloud, one = cloud;
  thin(many, 0.1);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  thin(one, 0.1);
  expect_same_columns(many, one);
}

TEST(ThinTest, on_the_order_of_points_it_depends_only_where_several_are_equally_near) {
  // Three in a row per cube: the middle one is the nearest.
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(0.1);
  std::mt19937_64 engine(14);
  for (int cube = 0; cube < 500; ++cube) {
    for (const int step : {1, 4, 8}) cloud.positions.emplace_back(10 * cube + step, step, 0);
  }
  PointCloud sorted = cloud, shuffled = cloud;
  std::shuffle(shuffled.positions.begin(), shuffled.positions.end(), engine);
  thin(sorted, 1.0);
  thin(shuffled, 1.0);
  const auto by_x = [](const LatticePosition& a, const LatticePosition& b) { return a.x < b.x; };
  std::sort(shuffled.positions.begin(), shuffled.positions.end(), by_x);
  EXPECT_EQ(sorted.positions, shuffled.positions);
  EXPECT_EQ(sorted.size(), 500u);
  EXPECT_EQ(sorted.positions[3].x, 34);
}

TEST(ThinTest, clouds_without_colours_and_empty_ones_are_thinned_too) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}, {5000, 0, 0}};
  thin(cloud, 1.0);
  EXPECT_EQ(cloud.positions, (std::vector<LatticePosition>{{0, 0, 0}, {5000, 0, 0}}));
  EXPECT_EQ(cloud.attributes(), AttributeSet());
  PointCloud empty;
  thin(empty, 1.0);
  EXPECT_EQ(empty.size(), 0u);
}

TEST(ThinTest, points_at_the_ends_of_the_lattice_do_not_overflow) {
  PointCloud cloud;
  constexpr int k_low = std::numeric_limits<int>::min(), k_high = std::numeric_limits<int>::max();
  cloud.positions = {
      {k_low, k_low, k_low}, {k_high, k_high, k_high}, {k_high - 1, k_high, k_high}, {0, 0, 0}};
  PointCloud one = cloud, most = cloud;
  one.lattice.offset = glm::dvec3(2147483.648);
  thin(one, 1e9);
  EXPECT_EQ(one.positions, (std::vector<LatticePosition>{{0, 0, 0}}));
  thin(most, 0.0011);
  EXPECT_EQ(most.size(), 3u) << "two share a cube";
}

TEST(ThinTest, an_edge_that_is_not_a_positive_number_is_an_error) {
  PointCloud cloud = full_cloud(5, 10, 15);
  for (const double edge :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(error_of([&] { thin(cloud, edge); }).find("invalid spacing"), std::string::npos);
  }
}

TEST(ThinTest, more_cubes_along_an_axis_than_32_bits_count_are_an_error) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {0, 2000000000, 0}};
  for (const double edge : {1e-4, 1e-300, std::numeric_limits<double>::denorm_min()}) {
    EXPECT_NE(error_of([&] { thin(cloud, edge); }).find("spacing too small for the extent of the cloud"),
              std::string::npos)
        << edge;
  }
}

TEST(ThinTest, progress_ends_with_all_points_and_can_stop_it) {
  PointCloud cloud = full_cloud(500, 100, 16);
  std::uint64_t last = 0;
  EXPECT_THROW(thin(cloud, 0.1, [](std::uint64_t, std::uint64_t) { return false; }), Cancelled);
  thin(cloud, 0.1, [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_EQ(total, 500u);
    EXPECT_GE(done, last);
    last = done;
    return true;
  });
  EXPECT_EQ(last, 500u);
}

}  // namespace
}  // namespace alidade
