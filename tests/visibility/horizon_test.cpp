// SPDX-License-Identifier: MIT
#include "visibility/horizon/horizon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "geo/earth.h"
#include "tests/support/random.h"
#include "tests/visibility/checked_sight.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

constexpr double k_degree = std::numbers::pi / 180.0;

double degrees(double radians) {
  return radians / k_degree;
}

/// In (-180, 180].
double angle_from(double azimuth, double middle) {
  return std::remainder(azimuth - middle, 360.0);
}

TEST(Horizon, of_a_wall_rises_to_its_top_edge) {
  // 30 m north, 80 m wide, from 2 m below to 8 m above the eye.
  constexpr double k_distance = 30.0, k_top = 8.0, k_half_width = 40.0, k_radius = 0.15;
  Points points;
  add_rectangle(points, {-k_half_width, k_distance, -2.0}, {2.0 * k_half_width, 0, 0}, {0, 0, 2.0 + k_top},
                0.1);
  const Occluders occluders(octree_of(points), {.radius = k_radius});
  const std::vector<HorizonDirection> line = horizon(occluders, {}, {.step = 1.0});
  ASSERT_EQ(line.size(), 360u);
  const double edge = degrees(std::atan2(k_half_width, k_distance));
  int walls = 0;
  for (const HorizonDirection& direction : line) {
    const double off = angle_from(direction.azimuth, 0.0);
    if (std::fabs(off) > edge + 0.5) {
      EXPECT_FALSE(direction.elevation) << direction.azimuth;
      EXPECT_FALSE(direction.blocker) << direction.azimuth;
      continue;
    }
    if (std::fabs(off) > edge - 0.5) continue;
    ++walls;
    ASSERT_TRUE(direction.elevation && direction.blocker) << direction.azimuth;
    const auto elevation_of = [&](double height) {
      return degrees(std::atan(height * std::cos(off * k_degree) / k_distance));
    };
    // Discs at the edge stand over it by up to their radius.
    EXPECT_GE(*direction.elevation, elevation_of(k_top + 0.5 * k_radius) - 0.01) << direction.azimuth;
    EXPECT_LE(*direction.elevation, elevation_of(k_top + k_radius)) << direction.azimuth;
    const double distance =
        k_distance / (std::cos(off * k_degree) * std::cos(*direction.elevation * k_degree));
    EXPECT_NEAR(direction.blocker->distance, distance, 1e-3) << direction.azimuth;
    EXPECT_NEAR(direction.blocker->position.z, k_top, k_radius);
    EXPECT_NEAR(glm::length(points[direction.blocker->point_id] - direction.blocker->position), 0.0, 1e-3);
  }
  EXPECT_GT(walls, 100);
}

TEST(Horizon, of_a_cone_is_that_of_its_silhouette) {
  // Apex 12 m above the eye, 40 m east; the base lies at the eye's height.
  constexpr double k_height = 12.0, k_base = 15.0, k_distance = 40.0;
  Points points;
  add_cone(points, {k_distance, 0.0, k_height}, k_height, k_base, 0.1);
  const Occluders occluders(octree_of(points), {});
  const std::vector<HorizonDirection> line = horizon(occluders, {}, {.elevation_min = 0.0});
  ASSERT_EQ(line.size(), 720u);
  constexpr double k_share = k_base / k_distance;
  const double half_width = degrees(std::asin(k_share));
  for (const HorizonDirection& direction : line) {
    const double off = std::fabs(angle_from(direction.azimuth, 90.0));
    if (off > half_width + 0.5) {
      EXPECT_FALSE(direction.elevation) << direction.azimuth;
      continue;
    }
    if (off > half_width - 0.5) continue;
    // The highest of the rays (H - k rho(d)) / d over all distances d along the azimuth.
    const double tangent =
        k_height / k_distance *
        (std::cos(off * k_degree) - std::sin(off * k_degree) * std::sqrt(1.0 - k_share * k_share) / k_share);
    ASSERT_TRUE(direction.elevation) << direction.azimuth;
    EXPECT_NEAR(*direction.elevation, degrees(std::atan(tangent)), 0.1) << direction.azimuth;
  }
}

TEST(Horizon, of_a_sphere_in_the_air_is_its_upper_edge) {
  constexpr double k_radius = 6.0, k_distance = 25.0, k_center = 7.0;
  Points points;
  add_sphere(points, {0.0, -k_distance, k_center}, k_radius, 60'000);
  const Occluders occluders(octree_of(points), {});
  const std::vector<HorizonDirection> line = horizon(occluders, {}, {});
  const double half_width = degrees(std::asin(k_radius / k_distance));
  for (const HorizonDirection& direction : line) {
    const double off = std::fabs(angle_from(direction.azimuth, 180.0));
    if (off > half_width + 0.3) {
      EXPECT_FALSE(direction.elevation) << direction.azimuth;
    }
    if (off > half_width - 0.3) continue;
    // The circle in the vertical plane of the azimuth.
    const double across = k_distance * std::sin(off * k_degree),
                 along = k_distance * std::cos(off * k_degree);
    const double circle = std::sqrt(k_radius * k_radius - across * across);
    const double top = std::atan2(k_center, along) + std::asin(circle / std::hypot(along, k_center));
    ASSERT_TRUE(direction.elevation) << direction.azimuth;
    EXPECT_NEAR(*direction.elevation, degrees(top), 0.05) << direction.azimuth;
  }
}

/// Walls, a plate in the air and leaves: a horizon with gaps below it.
Points garden(Random& random) {
  Points points;
  add_rectangle(points, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, 0.4);
  add_rectangle(points, {-6, 8, 0}, {12, 0, 0}, {0, 0, 3}, 0.2);
  add_rectangle(points, {5, -5, 4}, {4, 0, 0}, {0, 10, 0}, 0.2);
  for (int i = 0; i < 800; ++i) points.push_back(glm::dvec3(-8, -2, 4) + 1.5 * random.in_cube());
  return points;
}

TEST(Horizon, is_the_highest_blocked_of_all_lines) {
  Random random("Horizon.is_the_highest_blocked_of_all_lines");
  const Octree octree = octree_of(garden(random));
  for (const int transparency : {1, 2}) {
    const Occluders occluders(octree, {.transparency = transparency});
    const SightEnd eye{{0.3, 0.2, 1.7}};
    const HorizonOptions options{.step = 2.0, .resolution = 0.25};
    const std::vector<HorizonDirection> line = horizon(occluders, eye, options);
    ASSERT_EQ(line.size(), 180u);
    for (const HorizonDirection& direction : line) expect_highest_blocked(direction, occluders, eye);
  }
}

TEST(Horizon, is_cut_to_the_field_of_view) {
  Random random("Horizon.is_cut_to_the_field_of_view");
  const Occluders occluders(octree_of(garden(random)), {});
  const SightEnd eye{{0.3, 0.2, 1.7}};
  const std::vector<HorizonDirection> all = horizon(occluders, eye, {.step = 5.0, .resolution = 0.5});
  const std::vector<HorizonDirection> north =
      horizon(occluders, eye, {.step = 5.0, .resolution = 0.5, .azimuth_min = 350.0, .azimuth_max = 10.0});
  ASSERT_EQ(north.size(), 5u);
  for (std::size_t i = 0; i < north.size(); ++i) {
    const HorizonDirection& same = all[(70 + i) % 72];
    EXPECT_EQ(north[i].azimuth, same.azimuth);
    EXPECT_EQ(north[i].elevation, same.elevation);
  }
  for (const HorizonDirection& direction :
       horizon(occluders, eye, {.step = 5.0, .resolution = 0.5, .elevation_max = 3.0}))
    EXPECT_LE(direction.elevation.value_or(0.0), 3.0);
  const std::vector<HorizonDirection> near =
      horizon(occluders, eye, {.step = 5.0, .resolution = 0.5, .max_distance = 6.0});
  EXPECT_GT(*all.front().elevation, 5.0);
  ASSERT_TRUE(near.front().elevation);
  EXPECT_LT(*near.front().elevation, 0.0) << "the wall is 8 m away, the ground nearer";
  for (const HorizonDirection& direction : near)
    EXPECT_LE(direction.blocker.value_or(Blocker{}).distance, 6.0);
}

TEST(Horizon, options_out_of_range_are_errors) {
  const Occluders occluders(octree_of({{1, 0, 0}, {2, 0, 0}}), {.radius = 0.1});
  const HorizonOptions wrong[] = {
      {.step = 0.0},          {.step = 0.7},       {.step = 180.0},          {.resolution = 0.0},
      {.resolution = 0.017},  {.step = NAN},       {.elevation_min = -91.0}, {.elevation_max = NAN},
      {.max_distance = -1.0}, {.azimuth_min = NAN}};
  for (const HorizonOptions& options : wrong) EXPECT_THROW(horizon(occluders, {}, options), Error);
  EXPECT_THROW(horizon(occluders, {{NAN, 0, 0}}, {}), Error);
}

TEST(Horizon, of_an_empty_cloud_is_empty) {
  const Occluders occluders(octree_of({}), {.radius = 0.1});
  for (const HorizonDirection& direction : horizon(occluders, {}, {.step = 90.0}))
    EXPECT_FALSE(direction.elevation);
}

TEST(SkyAbove, a_line_is_the_mean_over_its_azimuths) {
  std::vector<HorizonDirection> line(4);
  EXPECT_EQ(sky_above(line).cosine_weighted, 1.0);
  EXPECT_EQ(sky_above(line).solid_angle, 1.0);
  line[0].elevation = 30.0;
  line[1].elevation = -20.0;
  line[2].elevation = 90.0;
  EXPECT_NEAR(sky_above(line).cosine_weighted, (0.75 + 1.0 + 0.0 + 1.0) / 4.0, 1e-15);
  EXPECT_NEAR(sky_above(line).solid_angle, (0.5 + 1.0 + 0.0 + 1.0) / 4.0, 1e-15);
}

TEST(SkyAbove, a_street_canyon_is_what_its_formula_says) {
  // Infinite walls on both sides, as far away as high: cos(45 degrees), and half of the sky's lune.
  std::vector<HorizonDirection> line(720);
  for (std::size_t i = 0; i < line.size(); ++i) {
    line[i].azimuth = 0.5 * static_cast<double>(i);
    line[i].elevation = degrees(std::atan(std::fabs(std::sin(line[i].azimuth * k_degree))));
  }
  EXPECT_NEAR(sky_above(line).cosine_weighted, std::sqrt(0.5), 1e-5);
  EXPECT_NEAR(sky_above(line).solid_angle, 0.5, 1e-5);
}

}  // namespace
}  // namespace alidade::test
