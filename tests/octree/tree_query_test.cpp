// SPDX-License-Identifier: MIT
#include "octree/tree_query.h"

#include "octree/query_targets.h"
#include "tests/octree/as_brute_force.h"
#include "tests/octree/explain.h"
#include "tests/support/kd_tree.h"
#include "tests/support/str_r_tree.h"

namespace alidade {
namespace {

using namespace test;

template <class Tree, class Target, class Query>
void expect_as_brute_force_on(const Tree& tree, const PointCloud& cloud, const QueryCase<Target, Query>& c,
                              const Pruning& pruning = {}) {
  const auto target = make_target(c.target, c.query, 0);
  Nearest neighbors(target, c.query.k);
  tree_query(tree, target, neighbors, pruning);
  const auto expected = brute_force::find(cloud, c.target, c.query);
  ASSERT_TRUE(same_hits(neighbors.in_order(), expected));
  Counter counter(c.query.k);
  tree_query(tree, target, counter, pruning);
  ASSERT_EQ(counter.count(), expected.size());
}

/// Calls check_case(cloud, case) for some cases of every kind around every point family.
template <class Check>
void for_every_kind_of_case(std::size_t count, const Check& check_case) {
  const std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  for (const PointFamily& family : point_families()) {
    const std::string seed = test + " " + family.name;
    Random random(seed);
    const auto check_all = [&](const auto& cases) {
      for (const auto& c : cases) {
        if (::testing::Test::HasFatalFailure()) return;
        SCOPED_TRACE("seed \"" + seed + "\": " + describe(c));
        check_case(family.cloud, c);
      }
    };
    check_all(find_ray_cases(family.cloud, count, random));
    check_all(cone_cases(family.cloud, count, random));
    check_all(path_cases(family.cloud, count, random));
    check_all(region_cases(family.cloud, count, random));
    check_all(box_cases(family.cloud, count, random));
    check_all(point_cases(family.cloud, count, random));
  }
}

TEST(TreeQueryVsBruteForce, an_r_tree_gives_the_same_bits) {
  const PointCloud* indexed = nullptr;
  std::optional<StrRTree> tree;
  for_every_kind_of_case(25, [&](const PointCloud& cloud, const auto& c) {
    if (indexed != &cloud) tree.emplace(cloud);
    indexed = &cloud;
    expect_as_brute_force_on(*tree, cloud, c);
  });
}

TEST(TreeQueryVsBruteForce, a_kd_tree_gives_the_same_bits) {
  const PointCloud* indexed = nullptr;
  std::optional<KdTree> tree;
  for_every_kind_of_case(25, [&](const PointCloud& cloud, const auto& c) {
    if (indexed != &cloud) tree.emplace(cloud);
    indexed = &cloud;
    expect_as_brute_force_on(*tree, cloud, c);
  });
}

std::vector<Pruning> every_pruning() {
  std::vector<Pruning> all;
  for (const DistanceBound distance : {DistanceBound::none, DistanceBound::sphere, DistanceBound::box}) {
    for (const bool time_interval : {false, true}) {
      for (const bool dynamic_k : {false, true}) all.push_back({distance, time_interval, dynamic_k});
    }
  }
  return all;
}

TEST(TreeQueryVsBruteForce, each_pruning_mechanism_off_gives_the_same_bits) {
  const PointCloud* indexed = nullptr;
  std::optional<Octree> octree;
  std::size_t turn = 0;
  for_every_kind_of_case(24, [&](const PointCloud& cloud, const auto& c) {
    if (indexed != &cloud) octree = build(cloud, {.leaf_size = 8});
    indexed = &cloud;
    const Pruning pruning = every_pruning()[turn++ % every_pruning().size()];
    SCOPED_TRACE(static_cast<int>(pruning.distance));
    expect_as_brute_force_on(OctreeTree(octree->view()), cloud, c, pruning);
  });
}

TEST(TreeQuery, boxes_that_only_touch_a_limit_are_not_discarded) {
  // The box of one point has all its faces where the point is, here exactly at a limit.
  const PointCloud cloud = make_cloud({{5, 0.5, 0}}, {glm::dvec3(0.001), glm::dvec3(0)});
  const StrRTree tree(cloud);
  const auto is_found = [&](const Ray& ray, const RayQuery& query) {
    const RayTarget target(ray, query);
    Counter counter(k_all);
    tree_query(tree, target, counter);
    return counter.count() == 1;
  };
  EXPECT_TRUE(is_found(make_ray({0, 0, 0}, {1, 0, 0}, 0.0, 5.0), {.radius = 0.5}));
  EXPECT_TRUE(is_found(make_ray({0, 0, 0}, {1, 0, 0}, 5.0, 9.0), {.radius = 0.5}));
  EXPECT_TRUE(is_found(make_ray({0, 0, 0}, {-1, 0, 0}, -5.0, 0.0), {.radius = 0.5}));
  EXPECT_TRUE(is_found(make_ray({0, 0, 0}, {1, 0, 0}), {.radius = 0.5, .entry_min = 5.0}));
  EXPECT_FALSE(is_found(make_ray({0, 0, 0}, {1, 0, 0}, 0.0, 4.999), {.radius = 0.5}));
}

/// A few thousand points in a cube and a ray across it.
class Pruned : public ::testing::Test {
 protected:
  Pruned() {
    Random random("Pruned");
    std::vector<glm::dvec3> positions;
    for (int i = 0; i < 20000; ++i) positions.push_back(10.0 * random.in_cube());
    octree_ = build(make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)}));
  }

  std::uint64_t visits(const RayQuery& query, const Pruning& pruning, double t_min = -1e9) {
    Ray ray = make_ray({-20, 1, 2}, {1, 0.3, -0.2});
    ray.t_min = t_min;
    return explain(octree_, ray, query, pruning).statistics.nodes_visited;
  }

  Octree octree_;
};

TEST_F(Pruned, ray_minimum_distance_visits_fewer_nodes) {
  const RayQuery within{.radius = 0.3};
  const std::uint64_t none = visits(within, {.distance = DistanceBound::none}),
                      sphere = visits(within, {.distance = DistanceBound::sphere}), box = visits(within, {});
  EXPECT_LT(sphere, none / 4);
  EXPECT_LT(box, sphere);
}

TEST_F(Pruned, projected_time_interval_visits_fewer_nodes) {
  const RayQuery within{.radius = 1.0};
  EXPECT_LT(visits(within, {}, 25.0), visits(within, {.time_interval = false}, 25.0));
}

TEST_F(Pruned, dynamic_k_visits_fewer_nodes_by_every_measure) {
  for (const Measure measure : {Measure::distance, Measure::t, Measure::entry}) {
    const RayQuery first{.radius = 1.0, .measure = measure, .k = 4};
    EXPECT_LT(visits(first, {}), visits(first, {.dynamic_k = false}));
  }
}

TEST_F(Pruned, statistics_tell_what_was_done) {
  const Ray ray = make_ray({-20, 1, 2}, {1, 0.3, -0.2}, 0.0, 22.0);
  const QueryStatistics near = explain(octree_, ray, {.radius = 0.5, .k = 3}).statistics;
  EXPECT_GT(near.nodes_visited, near.leaves_visited);
  EXPECT_GT(near.leaves_visited, 0u);
  EXPECT_GE(near.points_tested, near.leaves_visited);
  EXPECT_GT(near.pruned_by_distance, 0u);
  EXPECT_GT(near.pruned_by_interval, 0u);
  EXPECT_GT(near.pruned_by_k, 0u);
  const QueryStatistics all =
      explain(octree_, ray, {.radius = 0.5}, {DistanceBound::none, false, false}).statistics;
  EXPECT_EQ(all.points_tested, octree_.size());
  EXPECT_EQ(all.pruned_by_distance + all.pruned_by_interval + all.pruned_by_k, 0u);
}

TEST_F(Pruned, a_counter_stops_when_it_has_enough) {
  const Ray ray = make_ray({-20, 1, 2}, {1, 0.3, -0.2});
  const RayQuery within{.radius = 1.0};
  const RayTarget target(ray, within);
  Counter one(1), all(k_all);
  const QueryStatistics until_first = tree_query(OctreeTree(octree_.view()), target, one);
  const QueryStatistics until_end = tree_query(OctreeTree(octree_.view()), target, all);
  EXPECT_EQ(one.count(), 1u);
  EXPECT_GT(all.count(), 10u);
  EXPECT_LT(until_first.points_tested, until_end.points_tested / 4);
}

TEST(TreeQuery, gives_the_answers_of_find) {
  const PointFamily family = point_families().back();
  const Octree octree = build(family.cloud);
  Random random;
  const auto expect_same = [&](const auto& cases) {
    for (const auto& c : cases) {
      ASSERT_TRUE(same_hits(explain(octree, c.target, c.query).hits, find(octree, c.target, c.query)))
          << describe(c);
    }
  };
  expect_same(find_ray_cases(family.cloud, 20, random));
  expect_same(cone_cases(family.cloud, 20, random));
  expect_same(path_cases(family.cloud, 20, random));
  expect_same(region_cases(family.cloud, 20, random));
  expect_same(box_cases(family.cloud, 20, random));
  expect_same(point_cases(family.cloud, 20, random));
}

}  // namespace
}  // namespace alidade
