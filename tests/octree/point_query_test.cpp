// SPDX-License-Identifier: MIT
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

TEST(PointVsBruteForce, find_and_count_are_the_same_bits_on_every_family) {
  const Tally tally = expect_as_brute_force_on_every_family(120, point_cases);
  EXPECT_GT(tally.answers, 100000u);
  EXPECT_GT(tally.empty, 300u);
  EXPECT_GT(tally.cases - tally.empty, 500u);
}

TEST(Point, k_nearest_stand_in_the_order_of_distance) {
  const std::vector<PointHit> hits = find(build(three_points()), glm::dvec3(19, 0, 0), {.k = 2});
  EXPECT_EQ(ids_of(hits), (Ids{2, 0}));
  EXPECT_EQ(hits[0].distance, 1.0);
  EXPECT_EQ(hits[1].position, glm::dvec3(10, 0, 0));
}

TEST(Point, radius_is_inclusive) {
  const Octree octree = build(three_points());
  EXPECT_EQ(count(octree, glm::dvec3(15, 0, 0), {.radius = 5.0}), 2u);
  EXPECT_EQ(count(octree, glm::dvec3(15, 0, 0), {.radius = std::nextafter(5.0, 0.0)}), 0u);
}

TEST(Point, k_and_radius_hold_together) {
  const Octree octree = build(three_points());
  EXPECT_EQ(ids_of(find(octree, glm::dvec3(9, 0, 0), {.radius = 5.0, .k = 1})), (Ids{0}));
  EXPECT_EQ(ids_of(find(octree, glm::dvec3(9, 0, 0), {.radius = 5.0, .k = 9})), (Ids{0, 1}));
}

TEST(Point, without_k_and_radius_all_points_are_sorted_by_distance) {
  EXPECT_EQ(ids_of(find(build(three_points()), glm::dvec3(21, 0, 0), {})), (Ids{2, 0, 1}));
}

TEST(Point, equal_distances_stand_in_the_order_of_point_ids) {
  const PointCloud cloud =
      make_cloud(std::vector<glm::dvec3>(700, glm::dvec3(1, 2, 3)), {glm::dvec3(0.001), glm::dvec3(0)});
  EXPECT_EQ(ids_of(find(build(cloud), glm::dvec3(0), {.k = 4})), (Ids{0, 1, 2, 3}));
}

}  // namespace
}  // namespace alidade
