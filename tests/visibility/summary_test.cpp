// SPDX-License-Identifier: MIT
#include "visibility/points/summary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "base/error.h"
#include "tests/support/random.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade::test {

using namespace visibility;

namespace {

constexpr double k_pi = std::numbers::pi;

Observer eye_at(const glm::dvec3& position) {
  Observer observer;
  observer.position = position;
  observer.name = "eye";
  return observer;
}

ObserverSummary summary_of(const Points& points, const Observer& observer,
                           const SummaryOptions& options = {}) {
  return summarize(Occluders(octree_of(points), {}), {&observer, 1}, options).front();
}

/// Level ground, 40 x 40 around the origin, with points at random.
Points meadow(int count = 30000) {
  Random random;
  Points points;
  for (int i = 0; i < count; ++i) points.push_back({random.between(-20, 20), random.between(-20, 20), 0.0});
  return points;
}

/// A closed room of 10 x 8 x 3 around the origin.
Points room() {
  Points points;
  for (const double side : {-1.0, 1.0}) {
    add_rectangle(points, {-5, -4, 1.5 * side}, {10, 0, 0}, {0, 8, 0}, 0.1);
    add_rectangle(points, {-5, 4 * side, -1.5}, {10, 0, 0}, {0, 0, 3}, 0.1);
    add_rectangle(points, {5 * side, -4, -1.5}, {0, 8, 0}, {0, 0, 3}, 0.1);
  }
  return points;
}

TEST(Summary, of_a_meadow_is_all_of_it) {
  const ObserverSummary seen = summary_of(meadow(), eye_at({0, 0, 4}), {.bands = {10.0}, .step = 2.0});
  EXPECT_EQ(seen.visible_points, 30000u);
  EXPECT_NEAR(seen.area.visible, 1600.0, 0.05 * 1600.0);
  EXPECT_EQ(seen.area.visible, seen.area.all);
  // Within 10 of the eye, 4 above: a circle of radius sqrt(84).
  ASSERT_EQ(seen.bands.size(), 2u);
  EXPECT_NEAR(seen.bands[0].visible, 84.0 * k_pi, 0.05 * 84.0 * k_pi);
  EXPECT_EQ(seen.bands[0].visible + seen.bands[1].visible, seen.area.visible);
  ASSERT_TRUE(seen.distances);
  EXPECT_NEAR(seen.distances->min, 4.0, 0.05);
  EXPECT_NEAR(seen.distances->max, std::sqrt(816.0), 0.3);
  // Half of the area is in a circle of radius sqrt(800 / pi), which is within the square.
  EXPECT_NEAR(seen.distances->median, std::hypot(std::sqrt(800.0 / k_pi), 4.0), 0.3);
  ASSERT_TRUE(seen.isovist);
  EXPECT_EQ(seen.isovist->open, 1.0);
  EXPECT_NEAR(seen.isovist->area, 1600.0, 2.0) << "radials end at the edge of the cloud";
  EXPECT_NEAR(seen.isovist->max, std::sqrt(800.0), 0.1);
  EXPECT_NEAR(seen.volume, 6400.0, 0.02 * 6400.0) << "the box that eye and ground lie in";
  EXPECT_EQ(seen.sky.cosine_weighted, 1.0);
  EXPECT_TRUE(seen.class_areas.empty());
  EXPECT_FALSE(seen.relief);
}

TEST(Summary, of_a_closed_room_is_the_room) {
  const ObserverSummary seen = summary_of(room(), eye_at({0, 0, 0}), {.directions = 20000});
  EXPECT_NEAR(seen.area.visible / seen.area.all, 1.0, 0.01);
  // A regular grid: its points represent pi / 4 of their cells.
  EXPECT_NEAR(seen.area.visible, 0.25 * k_pi * 268.0, 0.05 * 268.0);
  ASSERT_TRUE(seen.isovist);
  EXPECT_EQ(seen.isovist->open, 0.0);
  EXPECT_NEAR(seen.isovist->area, 80.0, 0.1);
  EXPECT_NEAR(seen.isovist->max, std::hypot(5.0, 4.0), 0.1);
  EXPECT_NEAR(seen.volume, 240.0, 1.0);
  EXPECT_EQ(seen.sky.cosine_weighted, 0.0);
  EXPECT_EQ(seen.sky.solid_angle, 0.0);
  ASSERT_TRUE(seen.horizon);
  EXPECT_NEAR(seen.horizon->min, 90.0, 0.02) << "the ceiling";
}

TEST(Summary, of_a_hemisphere_is_its_radius) {
  Points points;
  add_sphere(points, {0, 0, 0}, 10.0, 60000);
  std::erase_if(points, [](const glm::dvec3& point) { return point.z < 0.0; });
  add_rectangle(points, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0}, 0.15);
  std::erase_if(points, [](const glm::dvec3& point) { return glm::length(point) > 10.01; });
  const ObserverSummary seen = summary_of(points, eye_at({0, 0, 1}), {.directions = 20000});
  EXPECT_NEAR(seen.volume, 2000.0 / 3.0 * k_pi, 20.0);
  ASSERT_TRUE(seen.isovist);
  EXPECT_NEAR(seen.isovist->area, 99.0 * k_pi, 1.5);
  EXPECT_NEAR(seen.isovist->mean, std::sqrt(99.0), 0.03);
  EXPECT_LT(seen.isovist->deviation, 0.03);
  EXPECT_NEAR(seen.distances->max, std::hypot(10.0, 1.0), 0.1);
}

TEST(Summary, a_round_wall_is_an_even_horizon) {
  constexpr double k_radius = 10.0, k_height = 10.0;
  Points points;
  for (int ring = 0; ring <= 100; ++ring) {
    for (int i = 0; i < 630; ++i) {
      const double turn = 2.0 * k_pi * i / 630;
      points.push_back({k_radius * std::cos(turn), k_radius * std::sin(turn), 0.01 * ring * k_height});
    }
  }
  const ObserverSummary seen = summary_of(points, eye_at({0, 0, 0}));
  ASSERT_TRUE(seen.horizon);
  EXPECT_NEAR(seen.horizon->mean, 45.0, 0.5);
  EXPECT_LT(seen.horizon->deviation, 0.1);
  // The open sky above the elevation h: cos^2 h, and 1 - sin h of the solid angle.
  EXPECT_NEAR(seen.sky.cosine_weighted, 0.5, 0.02);
  EXPECT_NEAR(seen.sky.solid_angle, 1.0 - std::sqrt(0.5), 0.02);
  ASSERT_TRUE(seen.isovist);
  EXPECT_NEAR(seen.isovist->area, k_pi * k_radius * k_radius, 1.0);
}

TEST(Summary, the_field_of_view_limits_all_but_the_sky) {
  Observer north = eye_at({0, 0, 4});
  north.azimuth_min = 270.0;
  north.azimuth_max = 90.0;
  north.max_distance = 12.0;
  const ObserverSummary seen = summary_of(meadow(), north, {.step = 2.0});
  EXPECT_NEAR(seen.area.visible, 0.5 * k_pi * 128.0, 0.05 * 200.0);
  EXPECT_LE(seen.distances->max, 12.0);
  ASSERT_TRUE(seen.isovist);
  EXPECT_NEAR(seen.isovist->area, 0.5 * k_pi * 144.0, 2.0);
  EXPECT_EQ(seen.isovist->mean, 12.0);
  EXPECT_EQ(seen.sky.solid_angle, 1.0);
  north.elevation_max = -10.0;
  EXPECT_FALSE(summary_of(meadow(), north, {.step = 10.0}).isovist);
}

TEST(Summary, classes_share_the_visible_area) {
  const Points points = meadow();
  std::vector<std::uint8_t> classes;
  for (const glm::dvec3& point : points) classes.push_back(point.x < 0.0 ? 2 : 6);
  const ObserverSummary seen = summary_of(points, eye_at({0, 0, 4}), {.classes = classes, .step = 10.0});
  EXPECT_NEAR(seen.class_areas[2] / seen.area.visible, 0.5, 0.02);
  EXPECT_NEAR(seen.class_areas[2] + seen.class_areas[6], seen.area.visible, 1e-9);
  EXPECT_EQ(seen.ground_area(), seen.class_areas[2]);
  ASSERT_TRUE(seen.diversity && seen.relief);
  EXPECT_NEAR(*seen.diversity, std::numbers::ln2, 0.001);
  EXPECT_EQ(*seen.relief, 0.0);
}

TEST(Summary, of_nothing_has_no_distances) {
  Observer blind = eye_at({0, 0, 4});
  blind.max_distance = 1.0;
  const ObserverSummary seen = summary_of(meadow(1000), blind, {.step = 30.0});
  EXPECT_EQ(seen.visible_points, 0u);
  EXPECT_EQ(seen.area.visible, 0.0);
  EXPECT_FALSE(seen.distances);
  EXPECT_FALSE(seen.horizon);
}

TEST(Summary, bands_out_of_order_are_errors) {
  const Points points = meadow(100);
  for (const std::vector<double>& bands : {std::vector{10.0, 10.0}, {0.0}, {-1.0, 5.0}, {20.0, 10.0}})
    EXPECT_THROW(summary_of(points, eye_at({0, 0, 4}), {.bands = bands}), Error);
}

}  // namespace
}  // namespace alidade::test
