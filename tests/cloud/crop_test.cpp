// SPDX-License-Identifier: MIT
#include "cloud/select_points.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/cloud/chosen_points.h"

namespace alidade {
namespace {

using test::expect_same_columns;
using test::full_cloud;
using test::rows_of;

constexpr double k_infinity = std::numeric_limits<double>::infinity();

/// Rows of a cloud for which `stays(world position)` holds.
template <class Stays>
PointCloud rows_where(const PointCloud& cloud, const Stays& stays) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < cloud.size(); ++row) {
    if (stays(cloud.world(row))) rows.push_back(row);
  }
  return rows_of(cloud, rows);
}

/// A cloud of points at these positions, lattice steps of 1.
PointCloud points_at(const std::vector<LatticePosition>& positions, double offset = 0.0) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(1.0), .offset = glm::dvec3(offset)};
  cloud.positions = positions;
  return cloud;
}

/// All points of a square grid from -n to n.
PointCloud grid(int n) {
  std::vector<LatticePosition> positions;
  for (int x = -n; x <= n; ++x) {
    for (int y = -n; y <= n; ++y) positions.emplace_back(x, y, 0);
  }
  return points_at(positions);
}

/// Even-odd and border, from the definition, in whole numbers: for polygons with whole corners only.
bool contains(const PlanePolygon& polygon, std::int64_t x, std::int64_t y) {
  bool inside = false;
  for (const auto& ring : polygon.rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const glm::i64vec2 a(ring[i]), b(ring[(i + 1) % ring.size()]);
      const std::int64_t side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
      if (side == 0 && x >= std::min(a.x, b.x) && x <= std::max(a.x, b.x) && y >= std::min(a.y, b.y) &&
          y <= std::max(a.y, b.y))
        return true;
      // Right of an edge that goes up, or left of one that goes down, the ray to the east meets nothing.
      if (a.y <= y && b.y > y && side > 0) inside = !inside;
      if (b.y <= y && a.y > y && side < 0) inside = !inside;
    }
  }
  return inside;
}

PlanePolygon random_polygon(std::mt19937_64& engine, int n, std::size_t rings, std::size_t corners) {
  PlanePolygon polygon;
  for (std::size_t r = 0; r < rings; ++r) {
    auto& ring = polygon.rings.emplace_back();
    for (std::size_t i = 0; i < corners; ++i) {
      ring.emplace_back(static_cast<double>(engine() % (2 * static_cast<unsigned>(n) + 1)) - n,
                        static_cast<double>(engine() % (2 * static_cast<unsigned>(n) + 1)) - n);
    }
  }
  return polygon;
}

TEST(CropTest, points_in_the_box_stay_in_their_order_with_all_attributes) {
  const PointCloud cloud = full_cloud(20000, 500, 1);
  const Bounds box{{689997.005, 5324998.005, 100.01}, {690001.005, 5325004.005, 105.01}};
  PointCloud cropped = cloud;
  crop(cropped, box);
  EXPECT_GT(cropped.size(), 1000u);
  expect_same_columns(cropped,
                      rows_where(cloud, [&](const glm::dvec3& position) { return box.contains(position); }));
}

TEST(CropTest, faces_of_the_box_belong_to_it) {
  PointCloud cloud = grid(3);
  crop(cloud, {{-1, -2, 0}, {2, 1, 0}});
  EXPECT_EQ(cloud.size(), 16u);
}

TEST(CropTest, limits_that_round_apart_from_the_positions_still_hold_them) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000.0, 5325000.0, 0.0}};
  for (int i = 0; i < 10000; ++i) cloud.positions.emplace_back(i, -i, i);
  // Each position as it would be typed, in decimals.
  for (int i = 0; i < 10000; i += 37) {
    const double x = (690000000 + i) / 1000.0, y = (5325000000 - i) / 1000.0, z = i / 1000.0;
    PointCloud one = cloud;
    crop(one, Bounds{{x, y, z}, {x, y, z}});
    EXPECT_EQ(one.size(), 1u) << i;
  }
}

TEST(CropTest, a_point_a_step_outside_goes) {
  PointCloud cloud = points_at({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  crop(cloud, Bounds{glm::dvec3(-0.99), glm::dvec3(0.99)});
  EXPECT_EQ(cloud.size(), 1u);
}

TEST(CropTest, sides_may_be_infinite) {
  PointCloud cloud = points_at({{0, 0, -2000000000}, {0, 0, 2000000000}, {5, 0, 0}});
  crop(cloud, {{-1, -k_infinity, -k_infinity}, {1, k_infinity, k_infinity}});
  EXPECT_EQ(cloud.size(), 2u);
}

TEST(CropPolygonTest, inside_is_what_lies_in_an_odd_number_of_rings_or_on_a_border) {
  std::mt19937_64 engine(7);
  for (int trial = 0; trial < 200; ++trial) {
    const PlanePolygon polygon =
        random_polygon(engine, 12, 1 + engine() % 3, 1 + engine() % (trial % 10 == 0 ? 60 : 7));
    const PointCloud cloud = grid(13);
    PointCloud cropped = cloud;
    crop(cropped, std::span(&polygon, 1));
    expect_same_columns(cropped, rows_where(cloud, [&](const glm::dvec3& position) {
                          return contains(polygon, std::lround(position.x), std::lround(position.y));
                        }));
  }
}

TEST(CropPolygonTest, a_point_stays_if_it_lies_in_at_least_one_polygon) {
  std::mt19937_64 engine(8);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<PlanePolygon> polygons;
    for (int i = 0; i < 6; ++i) polygons.push_back(random_polygon(engine, 12, 1, 4));
    polygons.push_back(polygons[0]);  // twice is not outside
    const PointCloud cloud = grid(13);
    PointCloud cropped = cloud;
    crop(cropped, polygons);
    expect_same_columns(cropped, rows_where(cloud, [&](const glm::dvec3& position) {
                          for (const PlanePolygon& polygon : polygons) {
                            if (contains(polygon, std::lround(position.x), std::lround(position.y)))
                              return true;
                          }
                          return false;
                        }));
  }
}

TEST(CropPolygonTest, rings_inside_others_are_holes_whichever_way_they_run) {
  PlanePolygon polygon{.rings = {{{-4, -4}, {4, -4}, {4, 4}, {-4, 4}}, {{-2, -2}, {2, -2}, {2, 2}, {-2, 2}}}};
  for (int turn = 0; turn < 2; ++turn) {
    PointCloud cloud = grid(5);
    crop(cloud, std::span(&polygon, 1));
    EXPECT_EQ(cloud.size(), 81u - 9u) << "borders of the hole stay";
    std::reverse(polygon.rings[1].begin(), polygon.rings[1].end());
  }
}

TEST(CropPolygonTest, height_does_not_matter) {
  PointCloud cloud = points_at({{0, 0, -2000000000}, {0, 0, 2000000000}, {9, 0, 0}});
  const PlanePolygon polygon{.rings = {{{-1, -1}, {1, -1}, {0, 1}}}};
  crop(cloud, std::span(&polygon, 1));
  EXPECT_EQ(cloud.size(), 2u);
}

TEST(CropPolygonTest, a_ring_of_one_or_two_corners_is_a_border_without_inside) {
  const PlanePolygon polygon{.rings = {{{3, 3}}, {{-2, 0}, {2, 0}}, {}}};
  PointCloud cloud = grid(4);
  crop(cloud, std::span(&polygon, 1));
  EXPECT_EQ(cloud.size(), 6u);
  PointCloud none = grid(2);
  crop(none, std::span<const PlanePolygon>());
  EXPECT_EQ(none.size(), 0u);
}

TEST(CropPolygonTest, points_on_slanted_borders_far_from_the_origin_stay) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.01), .offset = {690000.0, 5325000.0, 0.0}};
  for (int i = 0; i <= 1000; ++i) cloud.positions.emplace_back(3 * i, 7 * i, 0);
  const PlanePolygon polygon{
      .rings = {{{690000.0, 5325000.0}, {690030.0, 5325070.0}, {690030.0, 5325000.0}}}};
  crop(cloud, std::span(&polygon, 1));
  EXPECT_EQ(cloud.size(), 1001u);
}

TEST(CropPolygonTest, many_edges_that_cross_all_strips_are_found_as_well) {
  // A comb whose teeth run from south to north, and a circle of many short edges.
  PlanePolygon comb{.rings = {{}}};
  for (int i = -400; i < 400; ++i) {
    comb.rings[0].emplace_back(i, -400 + (i & 1) * 800);
  }
  PlanePolygon circle{.rings = {{}}};
  for (int i = 0; i < 5000; ++i) {
    const double angle = 2 * std::numbers::pi * i / 5000;
    circle.rings[0].emplace_back(std::round(100000 * std::cos(angle)), std::round(100000 * std::sin(angle)));
  }
  std::mt19937_64 engine(9);
  for (const auto& [polygon, half] : {std::pair(comb, 450), std::pair(circle, 110000)}) {
    std::vector<LatticePosition> positions;
    for (int i = 0; i < 300; ++i) {
      const auto some = [&, size = static_cast<std::uint64_t>(2 * half)] {
        return static_cast<int>(engine() % size) - static_cast<int>(size / 2);
      };
      positions.emplace_back(some(), some(), 0);
    }
    const PointCloud cloud = points_at(positions);
    PointCloud cropped = cloud;
    crop(cropped, std::span(&polygon, 1));
    EXPECT_GT(cropped.size(), 50u);
    EXPECT_LT(cropped.size(), 290u);
    const PlanePolygon& ring = polygon;
    expect_same_columns(cropped, rows_where(cloud, [&ring](const glm::dvec3& position) {
                          return contains(ring, std::lround(position.x), std::lround(position.y));
                        }));
  }
}

TEST(CropTest, the_result_does_not_depend_on_the_number_of_threads) {
  const PointCloud cloud = full_cloud(50000, 500, 2);
  std::mt19937_64 engine(10);
  PlanePolygon polygon = random_polygon(engine, 5, 1, 40);
  for (glm::dvec2& corner : polygon.rings[0]) corner += glm::dvec2(690000, 5325000);
  PointCloud many = cloud, one = cloud;
  crop(many, std::span(&polygon, 1));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  crop(one, std::span(&polygon, 1));
  EXPECT_GT(one.size(), 100u);
  expect_same_columns(many, one);
}

TEST(CropTest, progress_ends_with_all_points_and_can_stop_it) {
  PointCloud cloud = full_cloud(5000, 500, 3);
  std::uint64_t last = 0, of = 0;
  const Bounds everything{glm::dvec3(-k_infinity), glm::dvec3(k_infinity)};
  crop(cloud, everything, [&](std::uint64_t done, std::uint64_t total) {
    last = done;
    of = total;
    return true;
  });
  EXPECT_EQ(last, 5000u);
  EXPECT_EQ(of, 5000u);
  EXPECT_EQ(cloud.size(), 5000u);
  EXPECT_THROW(crop(cloud, everything, [](std::uint64_t, std::uint64_t) { return false; }), Cancelled);
}

}  // namespace
}  // namespace alidade
