// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/query.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
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

std::string describe(const PointFamily& family, InstructionSet set, const RayCase& c) {
  std::ostringstream text;
  text << family.name << " " << name(set) << std::hexfloat << " origin " << c.ray.origin.x << " "
       << c.ray.origin.y << " " << c.ray.origin.z << " direction " << c.ray.direction.x << " "
       << c.ray.direction.y << " " << c.ray.direction.z << " t " << c.ray.t_min << " " << c.ray.t_max
       << " radius " << c.query.radius << " entry_min " << c.query.entry_min
       << (c.query.measure == Measure::t ? " by t" : " by entry");
  return text.str();
}

BuildOptions options_for(InstructionSet set) {
  BuildOptions options;
  options.instruction_set = set;
  return options;
}

class RayQueryVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(RayQueryVsBruteForce, closest_and_occluded_are_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const PointFamily& family : point_families()) {
    const Octree octree = build(family.cloud, options_for(GetParam()));
    Random random(family.name + "_rays");
    for (const RayCase& c : ray_cases(family.cloud, 2000, random)) {
      SCOPED_TRACE(describe(family, GetParam(), c));
      const std::optional<Hit> expected = brute_force::closest(family.cloud, c.ray, c.query);
      ASSERT_TRUE(same_hits(closest(octree, c.ray, c.query), expected));
      ASSERT_EQ(occluded(octree, c.ray, c.query), expected.has_value());
      ++(expected ? hit_count : miss_count);
    }
  }
  EXPECT_GT(hit_count, 8000u);
  EXPECT_GT(miss_count, 8000u);
}

TEST_P(RayQueryVsBruteForce, organisation_and_leaf_size_do_not_change_answers) {
  for (const PointFamily& family : point_families()) {
    for (const test::NamedOctree& named : test::octrees_of(family.cloud, GetParam())) {
      Random random(family.name + "_organisation");
      for (const RayCase& c : ray_cases(family.cloud, 60, random)) {
        SCOPED_TRACE(describe(family, GetParam(), c) + " " + named.name);
        const std::optional<Hit> expected = brute_force::closest(family.cloud, c.ray, c.query);
        ASSERT_TRUE(same_hits(closest(named.octree, c.ray, c.query), expected));
        ASSERT_EQ(occluded(named.octree, c.ray, c.query), expected.has_value());
      }
    }
  }
}

TEST_P(RayQueryVsBruteForce, batches_are_the_same_bits_on_every_family) {
  for (const PointFamily& family : point_families()) {
    const Octree octree = build(family.cloud, options_for(GetParam()));
    Random random(family.name + "_batches");
    for (int turn = 0; turn < 12; ++turn) {
      // A batch has one query: that of its first ray. Some batches are coherent: a wide fan from one
      // position, a narrow one, whose rays meet the same leaves, the same ray again and again.
      std::vector<RayCase> cases = ray_cases(family.cloud, 60, random);
      const RayQuery query = cases[0].query;
      std::vector<Ray> rays;
      for (RayCase& c : cases) {
        if (turn % 4 >= 1) c.ray.origin = cases[0].ray.origin;
        if (turn % 4 >= 2) c.ray.direction = cases[0].ray.direction;
        if (turn % 4 == 2) c.ray.direction = unit_direction(c.ray.direction + 0.01 * random.in_cube());
        c.query = query;
        rays.push_back(c.ray);
      }
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(describe(family, GetParam(), cases[i]) + " ray " + std::to_string(i));
        const std::optional<Hit> expected = brute_force::closest(family.cloud, rays[i], query);
        ASSERT_TRUE(same_hits(hits[i], expected));
        ASSERT_EQ(blocked[i] != 0, expected.has_value());
      }
    }
  }
}

TEST_P(RayQueryVsBruteForce, spheres_that_begin_within_a_nanometre_of_each_other_are_told_apart_in_batches) {
  // Points in a ring around a line, as exactly as the lattice allows, and rays along that line.
  const glm::dvec3 along = unit_direction({0.6, 0.5, 0.4}), across = unit_direction({0.5, -0.6, 0.0});
  const glm::dvec3 middle(0.9, 0.8, 0.7), third = glm::cross(along, across);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 20; ++i)
    points.push_back(middle + 0.05 * (std::cos(0.3 * i) * across + std::sin(0.3 * i) * third));
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-9), glm::dvec3(0)});
  const Octree octree = build(cloud, options_for(GetParam()));
  for (const Measure measure : {Measure::entry, Measure::t}) {
    const RayQuery query{.radius = 0.06, .measure = measure};
    Random random("ring");
    std::vector<Ray> rays;
    for (int i = 0; i < 400; ++i) {
      const double beside = std::pow(10.0, random.between(-12.0, -6.0));
      rays.push_back(make_ray(middle - along + beside * random.in_cube(), along, 0.0));
    }
    std::vector<std::optional<Hit>> hits(rays.size());
    closest(octree, rays, query, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      SCOPED_TRACE(i);
      ASSERT_TRUE(same_hits(hits[i], brute_force::closest(cloud, rays[i], query)));
      ASSERT_TRUE(same_hits(closest(octree, rays[i], query), hits[i]));
    }
  }
}

TEST_P(RayQueryVsBruteForce, a_point_that_floats_are_not_sure_of_is_decided_in_double) {
  // It lies where the interval ends; a second point makes a box of some size.
  const PointCloud cloud = test::make_cloud({{0, 0, 1}, {5, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
  const Octree octree = build(cloud, options_for(GetParam()));
  for (const Measure measure : {Measure::entry, Measure::t}) {
    const RayQuery query{.radius = 0.1, .measure = measure};
    const Ray to_the_point = make_ray({0, 0, 0}, {0, 0, 1}, 0.0, 1.0);
    EXPECT_TRUE(occluded(octree, to_the_point, query));
    EXPECT_TRUE(closest(octree, to_the_point, query));
    const Ray shorter = make_ray({0, 0, 0}, {0, 0, 1}, 0.0, std::nextafter(1.0, 0.0));
    EXPECT_FALSE(occluded(octree, shorter, query));
    EXPECT_FALSE(closest(octree, shorter, query));
  }
}

INSTANTIATE_TEST_SUITE_P(, RayQueryVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

PointCloud three_points_on_a_line() {
  return test::make_cloud({{10, 0, 0}, {5, 0.5, 0}, {20, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
}

TEST(RayQuery, distance_limit_is_inclusive) {
  const Octree octree = build(three_points_on_a_line());
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  EXPECT_EQ(closest(octree, ray, {.radius = 0.5, .measure = Measure::t})->point_id, 1u);
  EXPECT_EQ(closest(octree, ray, {.radius = std::nextafter(0.5, 0.0), .measure = Measure::t})->point_id, 0u);
}

TEST(RayQuery, interval_limits_are_inclusive) {
  const Octree octree = build(three_points_on_a_line());
  const RayQuery query{.radius = 0.1, .measure = Measure::t};
  EXPECT_EQ(closest(octree, make_ray({0, 0, 0}, {1, 0, 0}, 20.0, 20.0), query)->point_id, 2u);
  EXPECT_FALSE(closest(octree, make_ray({0, 0, 0}, {1, 0, 0}, std::nextafter(20.0, 30.0), 30.0), query));
  EXPECT_FALSE(closest(octree, make_ray({0, 0, 0}, {1, 0, 0}, 10.5, std::nextafter(20.0, 0.0)), query));
}

TEST(RayQuery, by_default_all_of_the_line_counts) {
  const Octree octree = build(three_points_on_a_line());
  EXPECT_EQ(closest(octree, make_ray({100, 0, 0}, {1, 0, 0}), {.radius = 0.1})->t, -90.0);
}

TEST(RayQuery, an_empty_interval_holds_nothing) {
  const Octree octree = build(three_points_on_a_line());
  EXPECT_FALSE(closest(octree, make_ray({0, 0, 0}, {1, 0, 0}, 20.0, 10.0), {.radius = 1.0}));
  EXPECT_FALSE(occluded(octree, make_ray({0, 0, 0}, {1, 0, 0}, 20.0, 10.0), {.radius = 1.0}));
}

TEST(RayQuery, entry_is_where_the_sphere_begins) {
  const Octree octree = build(three_points_on_a_line());
  const std::optional<Hit> hit = closest(octree, make_ray({0, 0, 0}, {1, 0, 0}), {.radius = 2.0});
  EXPECT_EQ(hit->point_id, 1u);
  EXPECT_EQ(hit->entry, 5.0 - std::sqrt(4.0 - 0.25));
}

TEST(RayQuery, measures_order_differently) {
  // The sphere of the farther point, met in the middle, begins before that of the nearer point, met at its
  // rim.
  const PointCloud cloud =
      test::make_cloud({{10, 0.99, 0}, {10.2, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
  const Octree octree = build(cloud);
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  EXPECT_EQ(closest(octree, ray, {.radius = 1.0, .measure = Measure::t})->point_id, 0u);
  EXPECT_EQ(closest(octree, ray, {.radius = 1.0, .measure = Measure::entry})->point_id, 1u);
}

TEST(RayQuery, entry_min_leaves_out_spheres_the_ray_starts_in) {
  const Octree octree = build(three_points_on_a_line());
  const Ray ray = make_ray({9.5, 0, 0}, {1, 0, 0}, 0.0);
  EXPECT_EQ(closest(octree, ray, {.radius = 1.0})->point_id, 0u);
  EXPECT_EQ(closest(octree, ray, {.radius = 1.0, .entry_min = 0.0})->point_id, 2u);
}

TEST(RayQuery, equal_measures_give_the_lowest_point_id) {
  std::vector<glm::dvec3> positions(1000, glm::dvec3(3.0, 0, 0));
  positions.resize(1500, glm::dvec3(2.0, 0, 0));
  const Octree octree = build(test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)}));
  EXPECT_EQ(closest(octree, make_ray({0, 0, 0}, {1, 0, 0}), {.radius = 0.1})->point_id, 1000u);
  EXPECT_EQ(closest(octree, make_ray({9, 0, 0}, {-1, 0, 0}), {.radius = 0.1})->point_id, 0u);
}

TEST(RayQuery, an_empty_octree_answers_nothing) {
  const Octree octree = build(PointCloud{});
  EXPECT_EQ(octree.size(), 0u);
  EXPECT_TRUE(octree.bounds().empty());
  EXPECT_FALSE(closest(octree, make_ray({0, 0, 0}, {1, 0, 0}), {.radius = 1.0}));
  EXPECT_FALSE(occluded(octree, make_ray({0, 0, 0}, {1, 0, 0}), {.radius = 1.0}));
}

TEST(RayQuery, a_radius_that_is_negative_or_not_finite_is_an_error) {
  const Octree octree = build(three_points_on_a_line());
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  for (const double radius : {-1.0, -1e-300, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW(closest(octree, ray, {.radius = radius}), Error);
    EXPECT_THROW(occluded(octree, ray, {.radius = radius}), Error);
  }
  EXPECT_THROW(closest(octree, ray, {.radius = 1.0, .entry_min = std::nan("")}), Error);
}

TEST(RayQuery, lengths_beyond_floats_are_still_exact) {
  const PointCloud cloud =
      test::make_cloud({{1e25, 0, 0}, {3e25, 1e24, 0}, {5e25, 0, 0}}, {glm::dvec3(1e22), glm::dvec3(0)});
  const Octree octree = build(cloud);
  for (const double radius : {1e20, 1e23, 2e24, 1e30}) {
    const Ray ray = make_ray({-1e25, 0, 0}, {1, 0, 0});
    EXPECT_EQ(closest(octree, ray, {.radius = radius}), brute_force::closest(cloud, ray, {.radius = radius}));
  }
}

TEST(RayQuery, a_batch_answers_each_ray_in_order_on_any_number_of_threads) {
  const std::vector<PointFamily> families = point_families();
  const PointCloud& cloud = families.back().cloud;
  const Octree octree = build(cloud);
  Random random;
  std::vector<Ray> rays;
  for (const RayCase& c : ray_cases(cloud, 3000, random)) rays.push_back(c.ray);
  const RayQuery query{.radius = 0.2};
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    std::vector<std::optional<Hit>> hits(rays.size());
    std::vector<std::uint8_t> blocked(rays.size());
    closest(octree, rays, query, hits);
    occluded(octree, rays, query, blocked);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(hits[i], closest(octree, rays[i], query)) << "ray " << i;
      ASSERT_EQ(blocked[i] != 0, hits[i].has_value()) << "ray " << i;
    }
  }
}

TEST(RayQuery, a_batch_whose_answers_have_no_room_is_an_error) {
  const Octree octree = build(three_points_on_a_line());
  const std::vector<Ray> rays(3, make_ray({0, 0, 0}, {1, 0, 0}));
  std::vector<std::optional<Hit>> hits(2);
  std::vector<std::uint8_t> blocked(4);
  EXPECT_THROW(closest(octree, rays, {.radius = 1.0}, hits), Error);
  EXPECT_THROW(occluded(octree, rays, {.radius = 1.0}, blocked), Error);
}

TEST(RayQuery, a_batch_on_an_empty_octree_answers_nothing) {
  const std::vector<Ray> rays(2, make_ray({0, 0, 0}, {1, 0, 0}));
  std::vector<std::optional<Hit>> hits(2, Hit{});
  std::vector<std::uint8_t> blocked(2, 1);
  closest(build(PointCloud{}), rays, {.radius = 1.0}, hits);
  occluded(build(PointCloud{}), rays, {.radius = 1.0}, blocked);
  EXPECT_EQ(hits, std::vector<std::optional<Hit>>(2));
  EXPECT_EQ(blocked, std::vector<std::uint8_t>(2, 0));
}

TEST(RayQuery, many_points_at_few_positions_keep_the_lowest_id) {
  // So many that all points of some subtrees have one position, on a lattice so fine that keys do not hold
  // positions.
  Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 40000; ++i)
    positions.push_back(0.0625 * std::floor(random.between(0, 3)) * glm::dvec3(1, 0, 1));
  for (const double scale : {0.0009765625, 0x1p-28}) {
    positions.back() = scale < 1e-6 ? glm::dvec3(1.5, 0, 0) : positions.back();
    const PointCloud cloud = test::make_cloud(positions, {glm::dvec3(scale), glm::dvec3(0)});
    const Octree octree = build(cloud);
    for (const RayCase& c : ray_cases(cloud, 300, random)) {
      ASSERT_EQ(closest(octree, c.ray, c.query), brute_force::closest(cloud, c.ray, c.query));
    }
  }
}

TEST(Octree, an_instruction_set_the_machine_lacks_is_an_error) {
  const std::vector<InstructionSet> available = available_instruction_sets();
  for (const InstructionSet set :
       {InstructionSet::scalar, InstructionSet::sse4, InstructionSet::avx2, InstructionSet::avx512}) {
    const bool has = std::ranges::find(available, set) != available.end();
    if (has) {
      EXPECT_EQ(build(PointCloud{}, options_for(set)).instruction_set(), set);
    } else {
      EXPECT_THROW(build(PointCloud{}, options_for(set)), Error);
    }
  }
}

TEST(Ray, a_direction_is_normalised_at_the_entrance) {
  for (const double scale : {1.0, 1e-300, 1e300, 7.0}) {
    const Ray ray = make_ray({0, 0, 0}, glm::dvec3(3, 0, 4) * scale);
    EXPECT_NEAR(ray.direction.x, 0.6, 1e-15);
    EXPECT_NEAR(ray.direction.z, 0.8, 1e-15);
  }
}

TEST(Ray, directions_and_origins_that_are_no_rays_are_errors) {
  const double infinity = std::numeric_limits<double>::infinity(), nan = std::nan("");
  EXPECT_THROW(make_ray({0, 0, 0}, {0, -0.0, 0}), Error);
  EXPECT_THROW(make_ray({0, 0, 0}, {nan, 0, 1}), Error);
  EXPECT_THROW(make_ray({0, 0, 0}, {infinity, 0, 1}), Error);
  EXPECT_THROW(make_ray({nan, 0, 0}, {0, 0, 1}), Error);
  EXPECT_THROW(make_ray({0, infinity, 0}, {0, 0, 1}), Error);
  EXPECT_THROW(make_ray({0, 0, 0}, {0, 0, 1}, nan), Error);
}

}  // namespace
}  // namespace alidade
