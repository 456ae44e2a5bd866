// SPDX-License-Identifier: MIT
#include "octree/path_index.h"
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

TEST(PathVsBruteForce, find_and_count_are_the_same_bits_on_every_family) {
  const Tally tally = expect_as_brute_force_on_every_family(80, path_cases);
  EXPECT_GT(tally.answers, 100000u);
  EXPECT_GT(tally.empty, 300u);
  EXPECT_GT(tally.cases - tally.empty, 500u);
}

PointCloud beside_a_corner() {
  return make_cloud({{5, 1, 0}, {11, -1, 0}, {9, 5, 0}, {10, 12, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
}

Path corner() {
  return make_path({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}});
}

TEST(Path, tells_segment_t_and_distance_of_the_nearest_position) {
  const std::vector<PathHit> hits = find(build(beside_a_corner()), corner(), {});
  ASSERT_EQ(hits.size(), 4u);
  EXPECT_EQ(hits[0].point_id, 0u);
  EXPECT_EQ(hits[0].segment, 0u);
  EXPECT_EQ(hits[0].t, 5.0);
  EXPECT_EQ(hits[0].distance, 1.0);
  EXPECT_EQ(hits[1].point_id, 1u);
  EXPECT_EQ(hits[1].t, 10.0);
  EXPECT_EQ(hits[1].distance, std::sqrt(2.0));
  EXPECT_EQ(hits[2].segment, 1u);
  EXPECT_EQ(hits[2].t, 15.0);
  EXPECT_EQ(hits[3].t, 20.0);
  EXPECT_EQ(hits[3].distance, 2.0);
}

TEST(Path, of_equally_near_segments_the_first_counts) {
  EXPECT_EQ(find(build(beside_a_corner()), corner(), {})[1].segment, 0u);
  // There and back again.
  const std::vector<PathHit> hits =
      find(build(beside_a_corner()), make_path({{0, 0, 0}, {10, 0, 0}, {0, 0, 0}}), {.k = 1});
  EXPECT_EQ(hits[0].segment, 0u);
  EXPECT_EQ(hits[0].t, 5.0);
}

TEST(Path, every_point_counts_once) {
  EXPECT_EQ(count(build(beside_a_corner()), make_path({{0, 0, 0}, {10, 0, 0}, {0, 0, 0}, {10, 0, 0}}), {}),
            4u);
}

TEST(Path, the_interval_is_asked_of_the_nearest_position_only) {
  Path path = corner();
  path.t_min = 6.0;
  // Point 0 is nearest at t = 5; that it is also near the rest of the path does not count.
  EXPECT_EQ(ids_of(find(build(beside_a_corner()), path, {})), (Ids{1, 2, 3}));
  path.t_min = 5.0;
  path.t_max = 10.0;
  EXPECT_EQ(ids_of(find(build(beside_a_corner()), path, {})), (Ids{0, 1}));
}

TEST(Path, distance_limit_is_inclusive) {
  const Octree octree = build(beside_a_corner());
  EXPECT_EQ(ids_of(find(octree, corner(), {.radius = 1.0})), (Ids{0, 2}));
  EXPECT_EQ(count(octree, corner(), {.radius = std::nextafter(1.0, 0.0)}), 0u);
}

TEST(Path, a_long_way_costs_no_more_than_what_is_near) {
  // A trajectory of many vertices over a large grid: a loop over all segments for every node and point would
  // take hours.
  std::vector<glm::dvec3> points, vertices;
  for (int i = 0; i < 400; ++i)
    for (int j = 0; j < 400; ++j) points.push_back({0.5 * i, 0.5 * j, 0});
  for (int i = 0; i <= 100000; ++i) vertices.push_back({0.002 * i, 100.0 + 0.01 * (i % 2), 0});
  const Octree octree = build(make_cloud(points, {glm::dvec3(0.001), glm::dvec3(0)}));
  const std::vector<PathHit> hits =
      find(octree, make_path(vertices), {.radius = 0.3, .measure = Measure::distance});
  EXPECT_EQ(hits.size(), 400u);
}

TEST(Path, make_path_joins_repeated_vertices) {
  const Path path = make_path({{0, 0, 0}, {0, 0, 0}, {3, 4, 0}, {3, 4, 0}, {3, 4, 1}, {3, 4, 1}});
  EXPECT_EQ(path.vertices, (std::vector<glm::dvec3>{{0, 0, 0}, {3, 4, 0}, {3, 4, 1}}));
  EXPECT_EQ(path.vertex_t, (std::vector<double>{0, 5, 6}));
}

TEST(Path, vertices_that_are_no_path_are_errors) {
  const double nan = std::nan("");
  EXPECT_THROW(make_path({}), Error);
  EXPECT_THROW(make_path({{0, 0, 0}}), Error);
  EXPECT_THROW(make_path({{0, 0, 0}, {0, 0, 0}}), Error);
  EXPECT_THROW(make_path({{0, 0, 0}, {1, 0, 0}}, nan), Error);
  EXPECT_THROW(make_path({{-1e308, 0, 0}, {1e308, 0, 0}}), Error);
  try {
    make_path({{0, 0, 0}, {1, 0, 0}, {1, nan, 0}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("vertex 2"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace alidade
