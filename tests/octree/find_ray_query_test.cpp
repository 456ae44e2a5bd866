// SPDX-License-Identifier: MIT
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

TEST(FindRayVsBruteForce, find_count_closest_and_occluded_are_the_same_bits_on_every_family) {
  const Tally tally = expect_as_brute_force_on_every_family(150, find_ray_cases);
  EXPECT_GT(tally.answers, 100000u);
  EXPECT_GT(tally.empty, 600u);
  EXPECT_GT(tally.cases - tally.empty, 800u);
}

TEST(FindRay, gives_the_first_k_by_the_measure_in_its_order) {
  const Octree octree = build(three_points());
  const Ray ray = make_ray({0, 0.01, 0}, {1, 0, 0});
  EXPECT_EQ(ids_of(find(octree, ray, {.measure = Measure::t})), (Ids{1, 0, 2}));
  EXPECT_EQ(ids_of(find(octree, ray, {.measure = Measure::distance})), (Ids{0, 2, 1}));
  EXPECT_EQ(ids_of(find(octree, ray, {.measure = Measure::distance, .k = 1})), (Ids{0}));
  EXPECT_EQ(ids_of(find(octree, ray, {.radius = 0.5, .measure = Measure::entry, .k = 2})), (Ids{1, 0}));
}

TEST(FindRay, equal_measures_stand_in_the_order_of_point_ids) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 500; ++i) positions.push_back({3.0, i % 2 ? 0.5 : -0.5, 0});
  const Octree octree = build(make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)}));
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  for (const Measure measure : {Measure::distance, Measure::t, Measure::entry}) {
    EXPECT_EQ(ids_of(find(octree, ray, {.radius = 1.0, .measure = measure, .k = 5})), (Ids{0, 1, 2, 3, 4}));
  }
}

TEST(FindRay, distance_limit_is_inclusive) {
  const Octree octree = build(three_points());
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  EXPECT_EQ(find(octree, ray, {.radius = 0.5}).size(), 3u);
  EXPECT_EQ(find(octree, ray, {.radius = std::nextafter(0.5, 0.0)}).size(), 2u);
  EXPECT_EQ(find(octree, ray, {.radius = 0.0}).size(), 2u);
}

TEST(FindRay, without_a_radius_every_point_of_the_interval_counts) {
  const Octree octree = build(three_points());
  EXPECT_EQ(ids_of(find(octree, make_ray({0, 99, 0}, {1, 0, 0}, 5, 10), {.measure = Measure::t})),
            (Ids{1, 0}));
}

TEST(FindRay, entry_is_minus_infinity_without_a_radius) {
  const std::vector<Hit> hits =
      find(build(three_points()), make_ray({0, 0, 0}, {1, 0, 0}), {.measure = Measure::t});
  ASSERT_EQ(hits.size(), 3u);
  EXPECT_EQ(hits[0].entry, -std::numeric_limits<double>::infinity());
}

TEST(FindRay, an_empty_interval_holds_nothing) {
  const Octree octree = build(three_points());
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0}, 20, 10);
  EXPECT_TRUE(find(octree, ray, {.measure = Measure::t}).empty());
  EXPECT_EQ(count(octree, ray, {.measure = Measure::t}), 0u);
}

TEST(FindRay, closest_is_k_1_whatever_k_is) {
  const Octree octree = build(three_points());
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  for (const std::size_t k : {std::size_t{1}, std::size_t{7}, k_all}) {
    const RayQuery query{.measure = Measure::t, .k = k};
    EXPECT_EQ(closest(octree, ray, query)->point_id, 1u);
    EXPECT_TRUE(occluded(octree, ray, query));
  }
}

TEST(FindRay, count_stops_at_k) {
  const Octree octree = build(three_points());
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  EXPECT_EQ(count(octree, ray, {.measure = Measure::t, .k = 2}), 2u);
  EXPECT_EQ(count(octree, ray, {.measure = Measure::t, .k = 9}), 3u);
  EXPECT_EQ(brute_force::count(three_points(), ray, {.measure = Measure::t, .k = 2}), 2u);
}

TEST(FindRay, a_direction_that_is_only_nearly_of_length_1_is_answered_as_brute_force_does) {
  // Such rays are within the contract, but too crooked for lanes.
  Random random;
  const PointFamily family = point_families().back();
  const Octree octree = build(family.cloud);
  for (FindRayCase& c : find_ray_cases(family.cloud, 100, random)) {
    c.target.direction *= random.between(1 - 9e-7, 1 + 9e-7);
    Tally tally;
    SCOPED_TRACE(describe(c));
    expect_as_brute_force(family.cloud, octree, c, tally);
  }
}

}  // namespace
}  // namespace alidade
