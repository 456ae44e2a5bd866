// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/candidate.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "tests/octree/explain.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/support/ray_families.h"
#include "tests/support/same_hits.h"

namespace alidade {
namespace {

using test::point_families;
using test::PointFamily;
using test::Random;
using test::ray_cases;
using test::RayCase;
using test::same_hits;

constexpr double k_factors[] = {0.01, 0.5, 1.0, 3.0, 1e6};

TEST(PointSpacing, is_the_distance_to_the_nth_point_elsewhere_rounded_up_to_eight_bits) {
  for (const PointFamily& family : point_families()) {
    for (const int neighbours : {1, 8}) {
      SCOPED_TRACE(family.name + " neighbour " + std::to_string(neighbours));
      const std::vector<double> expected = brute_force::spacings(family.cloud, neighbours);
      for (const test::NamedOctree& named : test::octrees_of(family.cloud, InstructionSet::best)) {
        SCOPED_TRACE(named.name);
        const Octree octree = with_spacings(named.octree, neighbours);
        if (octree.size() > 0) {
          ASSERT_EQ(spacings_in_order(octree.view()), expected);
        }
      }
    }
  }
}

TEST(PointSpacing, bits_are_the_least_that_are_not_below) {
  Random random("spacing_bits");
  for (int i = 0; i < 100000; ++i) {
    const double metres = std::pow(10.0, random.between(-30.0, 30.0));
    const std::uint16_t bits = spacing_bits(metres);
    ASSERT_GE(spacing_of(bits), metres);
    ASSERT_LT(spacing_of(static_cast<std::uint16_t>(bits - 1)), metres);
    ASSERT_LE(spacing_of(bits), metres * 1.0079);
  }
  EXPECT_EQ(spacing_of(spacing_bits(0.0)), 0.0f);
  EXPECT_EQ(spacing_of(spacing_bits(2.5)), 2.5f);
  EXPECT_TRUE(std::isinf(spacing_of(spacing_bits(std::numeric_limits<double>::infinity()))));
}

TEST(PointSpacing, of_a_line_of_points_is_known_on_paper) {
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(i, 0.0, 0.0);
  points.resize(101, points[50]);  // a twin
  const Octree octree = build(test::make_cloud(points, {glm::dvec3(0.5), glm::dvec3(0.0)}));
  const Octree measured = with_spacings(octree, 4);
  const std::vector<double> spacings = spacings_in_order(measured.view());
  EXPECT_EQ(spacings[0], 4.0);
  EXPECT_EQ(spacings[20], 2.0);
  EXPECT_EQ(spacings[50], 2.0);
  EXPECT_EQ(spacings[100], 2.0);
  EXPECT_EQ(spacings[51], 2.0) << "the twins count as two";
}

TEST(PointSpacing, numbers_of_neighbours_out_of_range_are_errors) {
  const Octree octree = build(point_families().front().cloud);
  EXPECT_THROW(with_spacings(octree, 0), Error);
  EXPECT_THROW(with_spacings(octree, k_most_spacing_neighbours + 1), Error);
}

class OwnRadiusVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(OwnRadiusVsBruteForce, closest_occluded_find_and_count_are_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const PointFamily& family : point_families()) {
    const std::vector<double> spacings = brute_force::spacings(family.cloud, 3);
    for (const test::NamedOctree& named : test::octrees_of(family.cloud, GetParam())) {
      const Octree octree = with_spacings(named.octree, 3);
      Random random(family.name + "_own_radius");
      for (RayCase& c : ray_cases(family.cloud, 25, random)) {
        c.query.spacing_factor = k_factors[random.below(5)];
        SCOPED_TRACE(family.name + " " + named.name + " factor " + std::to_string(c.query.spacing_factor));
        const std::vector<Hit> expected = brute_force::find(family.cloud, c.ray, c.query, spacings);
        const std::optional<Hit> first = expected.empty() ? std::nullopt : std::optional(expected.front());
        ASSERT_TRUE(same_hits(closest(octree, c.ray, c.query), first));
        ASSERT_EQ(occluded(octree, c.ray, c.query), first.has_value());
        ASSERT_TRUE(same_hits(find(octree, c.ray, c.query), expected));
        ASSERT_EQ(count(octree, c.ray, c.query), expected.size());
        ASSERT_TRUE(same_hits(test::explain(octree, c.ray, c.query).hits, expected));
        ++(first ? hit_count : miss_count);
      }
    }
  }
  EXPECT_GT(hit_count, 300u);
  EXPECT_GT(miss_count, 300u);
}

TEST_P(OwnRadiusVsBruteForce, batches_are_the_same_bits_on_every_family) {
  BuildOptions options;
  options.instruction_set = GetParam();
  for (const PointFamily& family : point_families()) {
    const std::vector<double> spacings = brute_force::spacings(family.cloud, 3);
    const Octree octree = with_spacings(build(family.cloud, options), 3);
    Random random(family.name + "_own_radius_batches");
    for (int turn = 0; turn < 8; ++turn) {
      std::vector<RayCase> cases = ray_cases(family.cloud, 60, random);
      RayQuery query = cases[0].query;
      query.spacing_factor = k_factors[random.below(5)];
      std::vector<Ray> rays;
      for (RayCase& c : cases) {
        if (turn % 4 >= 1) c.ray.origin = cases[0].ray.origin;
        if (turn % 4 >= 2) c.ray.direction = cases[0].ray.direction;
        if (turn % 4 == 2) c.ray.direction = unit_direction(c.ray.direction + 0.01 * random.in_cube());
        rays.push_back(c.ray);
      }
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(family.name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        const std::optional<Hit> expected = brute_force::closest(family.cloud, rays[i], query, spacings);
        ASSERT_TRUE(same_hits(hits[i], expected));
        ASSERT_EQ(blocked[i] != 0, expected.has_value());
      }
    }
  }
}

TEST_P(OwnRadiusVsBruteForce, filters_and_levels_hold_too) {
  for (const PointFamily& family : point_families()) {
    const std::vector<double> spacings = brute_force::spacings(family.cloud, 3);
    for (const test::NamedOctree& named : test::octrees_of(family.cloud, GetParam())) {
      const Octree octree = with_spacings(named.octree, 3);
      const bool is_layered = octree.view().organisation == Organisation::layered;
      const std::vector<int> levels = test::levels_by_id(octree);
      Random random(family.name + "_own_radius_filters");
      std::vector<RayCase> cases = ray_cases(family.cloud, 12, random);
      RayQuery query = cases[0].query;
      query.spacing_factor = 1.0;
      const int max_level = is_layered ? 1 : k_all_levels;
      query.filter = [&](const Candidate& point) {
        return point.point_id % 3 != 0 && levels[point.point_id] <= max_level;
      };
      const double middle = family.cloud.size() > 0 ? octree.bounds().center().x : 0.0;
      query.position_filter = [middle](const Candidate& point) { return point.position.x <= middle; };
      RayQuery of_levels = query;
      of_levels.filter = [](const Candidate& point) { return point.point_id % 3 != 0; };
      of_levels.max_level = max_level;
      std::vector<Ray> rays;
      for (const RayCase& c : cases) rays.push_back(c.ray);
      std::vector<std::optional<Hit>> hits(rays.size());
      closest(octree, rays, of_levels, hits);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(family.name + " " + named.name + " ray " + std::to_string(i));
        const std::optional<Hit> expected = brute_force::closest(family.cloud, rays[i], query, spacings);
        ASSERT_TRUE(same_hits(hits[i], expected));
        ASSERT_TRUE(same_hits(closest(octree, rays[i], of_levels), expected));
        ASSERT_EQ(occluded(octree, rays[i], of_levels), expected.has_value());
      }
    }
  }
}

/// Two walls, one scanned a hundred times as densely as the other, and rays that graze the points' spheres.
TEST_P(OwnRadiusVsBruteForce, spheres_of_very_different_radii_are_met_at_their_rims) {
  BuildOptions options;
  options.instruction_set = GetParam();
  Random random("two_walls");
  std::vector<glm::dvec3> points;
  const glm::dvec3 site(690000.0, 5325000.0, 0.0);
  for (int i = 0; i < 3000; ++i)
    points.push_back(site + glm::dvec3(random.between(0.0, 0.1), 0.0, random.between(0.0, 0.1)));
  for (int i = 0; i < 300; ++i)
    points.push_back(site + glm::dvec3(random.between(0.0, 10.0), 5.0, random.between(0.0, 10.0)));
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-6), site});
  const std::vector<double> spacings = brute_force::spacings(cloud, 8);
  const Octree octree = with_spacings(build(cloud, options), 8);
  for (const Measure measure : {Measure::entry, Measure::t}) {
    const RayQuery query{.radius = 2.0, .measure = measure, .spacing_factor = 0.5};
    std::vector<Ray> rays;
    for (int i = 0; i < 800; ++i) {
      const auto id = static_cast<std::size_t>(random.below(points.size()));
      const glm::dvec3 along = unit_direction(random.in_cube());
      const glm::dvec3 across = unit_direction(glm::cross(along, random.in_cube()));
      const double rim =
          own_radius(query, spacings[id]) * (1.0 + std::pow(10.0, random.between(-16.0, -3.0)));
      rays.push_back(make_ray(cloud.world(id) + rim * across - 3.0 * along, along, 0.0));
    }
    std::vector<std::optional<Hit>> hits(rays.size());
    closest(octree, rays, query, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      SCOPED_TRACE(i);
      const std::optional<Hit> expected = brute_force::closest(cloud, rays[i], query, spacings);
      ASSERT_TRUE(same_hits(hits[i], expected));
      ASSERT_TRUE(same_hits(closest(octree, rays[i], query), expected));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, OwnRadiusVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

TEST(OwnRadius, a_hit_tells_the_radius_of_its_sphere_from_any_distance) {
  Random random;
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 500; ++i) points.push_back(glm::dvec3(3.0, 3.0, 0.1) * random.in_cube());
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-4), glm::dvec3(0)});
  const Octree octree = with_spacings(build(cloud), 8);
  const std::vector<double> spacings = spacings_in_order(octree.view());
  std::size_t limited = 0;
  for (int i = 0; i < 20000; ++i) {
    const RayQuery query{.radius = random.between(0.1, 1.0), .spacing_factor = random.between(0.3, 2.0)};
    const glm::dvec3 along = unit_direction(random.direction());
    const double away = std::pow(10.0, random.between(0.0, 4.5));
    const glm::dvec3 target = glm::dvec3(3.0, 3.0, 0.1) * random.in_cube();
    const auto hit = closest(octree, make_ray(target - away * along, along), query);
    if (!hit) continue;
    const double expected = own_radius(query, spacings[hit->point_id]);
    if (std::fabs(query.radius - query.spacing_factor * spacings[hit->point_id]) > 1e-7) {
      ASSERT_EQ(sphere_radius(query, *hit), expected);
    }
    limited += expected == query.radius ? 1 : 0;
  }
  EXPECT_GT(limited, 100u);
}

TEST(OwnRadius, a_hit_of_few_points_tells_the_radius_known_on_paper) {
  const PointCloud cloud =
      test::make_cloud({{0, 0, 0}, {1, 0, 0}, {10, 0, 0}}, {glm::dvec3(0.5), glm::dvec3(0)});
  const Octree octree = with_spacings(build(cloud), 1);
  const RayQuery query{.radius = 4.0, .spacing_factor = 0.5};
  const auto small = closest(octree, make_ray({0.0, -5.0, 0.25}, {0.0, 1.0, 0.0}), query);
  ASSERT_TRUE(small);
  EXPECT_EQ(sphere_radius(query, *small), 0.5);
  const auto limited = closest(octree, make_ray({10.0, -5.0, 1.0}, {0.0, 1.0, 0.0}), query);
  ASSERT_TRUE(limited);
  EXPECT_EQ(sphere_radius(query, *limited), 4.0);
}

TEST(OwnRadius, without_spacings_or_with_a_bad_factor_is_an_error) {
  const PointCloud cloud = test::make_cloud({{0, 0, 0}, {1, 0, 0}}, {glm::dvec3(0.5), glm::dvec3(0)});
  const Octree octree = build(cloud);
  const Ray ray = make_ray({0.0, -5.0, 0.0}, {0.0, 1.0, 0.0});
  EXPECT_THROW(closest(octree, ray, {.radius = 1.0, .spacing_factor = 1.0}), Error);
  EXPECT_THROW(brute_force::closest(cloud, ray, {.radius = 1.0, .spacing_factor = 1.0}), Error);
  const Octree with = with_spacings(octree, 1);
  EXPECT_TRUE(closest(with, ray, {.radius = 1.0, .spacing_factor = 1.0}));
  for (const double bad :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(closest(with, ray, {.radius = 1.0, .spacing_factor = bad}), Error);
}

}  // namespace
}  // namespace alidade
