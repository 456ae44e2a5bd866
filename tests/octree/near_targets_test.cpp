// SPDX-License-Identifier: MIT
#include <tbb/global_control.h>

#include <algorithm>

#include "tests/octree/as_brute_force.h"
#include "tests/support/positions.h"

// Batches of points that are near each other share their way through the tree (octree/query.cpp).

namespace alidade {
namespace {

using namespace test;

constexpr std::size_t k_most = 64;

/// Dense where the cloud is, some far away, in no order.
std::vector<glm::dvec3> near_targets(const PointCloud& cloud, Random& random) {
  const Positions positions(cloud, random);
  std::vector<glm::dvec3> targets;
  for (int copy = 0; copy < 2; ++copy) {
    for (const PointHit& hit : brute_force::find(cloud, positions.point(), {.k = 120})) {
      targets.push_back(hit.position);
      if (random.below(3) == 0) targets.push_back(hit.position + positions.spacing() * random.in_cube());
    }
  }
  for (int i = 0; i < 40; ++i) targets.push_back(positions.anywhere());
  for (std::size_t i = targets.size(); i > 1; --i) std::swap(targets[i - 1], targets[random.below(i)]);
  return targets;
}

/// The k first within the radius, of the first ones without limits.
std::vector<PointHit> limited(const std::vector<PointHit>& first, const PointQuery& query) {
  std::vector<PointHit> answers;
  for (const PointHit& hit : first)
    if (hit.distance <= query.radius && answers.size() < query.k) answers.push_back(hit);
  return answers;
}

/// As columns, with nothing written behind them.
void expect_columns(const Octree& octree, const std::vector<glm::dvec3>& targets, const PointQuery& query,
                    const std::vector<std::vector<PointHit>>& expected) {
  constexpr std::int64_t k_untouched = -77;
  const std::size_t rows = query.k * targets.size();
  std::vector<std::int64_t> ids(rows + 1, k_untouched);
  std::vector<double> distances(rows + 1, k_untouched);
  find(octree, targets, query, {ids.data(), distances.data()});
  EXPECT_EQ(ids.back(), k_untouched);
  EXPECT_EQ(distances.back(), k_untouched);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::vector<PointHit>& hits = expected[row / query.k];
    const std::size_t j = row % query.k;
    const bool is_hit = j < hits.size();
    ASSERT_EQ(ids[row], is_hit ? static_cast<std::int64_t>(hits[j].point_id) : -1) << "row " << row;
    ASSERT_EQ(distances[row], is_hit ? hits[j].distance : std::numeric_limits<double>::infinity())
        << "row " << row;
  }
}

void expect_answers(const Octree& octree, const std::vector<glm::dvec3>& targets, const PointQuery& query,
                    const std::vector<std::vector<PointHit>>& expected) {
  expect_columns(octree, targets, query, expected);
  const Answers<PointHit> found = find(octree, targets, query);
  ASSERT_EQ(found.size(), targets.size());
  ASSERT_EQ(found.begin.back(), found.all.size());
  for (std::size_t i = 0; i < targets.size(); ++i)
    ASSERT_TRUE(same_hits(found[i], std::span<const PointHit>(expected[i]))) << "target " << i;
}

TEST(NearTargetsVsBruteForce, k_nearest_are_the_same_bits_in_every_organisation_and_instruction_set) {
  for (const PointFamily& family : point_families()) {
    if (family.cloud.size() == 0) continue;
    Random random(family.name + "_near_targets");
    const std::vector<glm::dvec3> targets = near_targets(family.cloud, random);
    std::vector<std::vector<PointHit>> first;
    for (const glm::dvec3& target : targets)
      first.push_back(brute_force::find(family.cloud, target, {.k = k_most}));
    const double spacing = Positions(family.cloud, random).spacing();
    for (const NamedOctree& named : octrees_of(family.cloud)) {
      for (const InstructionSet set : available_instruction_sets()) {
        const Octree octree = named.octree.with_instruction_set(set);
        for (const PointQuery& query :
             {PointQuery{.k = 1}, PointQuery{.k = 10}, PointQuery{.radius = spacing, .k = 10},
              PointQuery{.radius = 3.0 * spacing, .k = 10}, PointQuery{.k = k_most}}) {
          SCOPED_TRACE(family.name + ", " + named.name + ", " + std::string(name(set)) + ", k " +
                       std::to_string(query.k) + ", radius " + std::to_string(query.radius));
          std::vector<std::vector<PointHit>> expected;
          for (const std::vector<PointHit>& one : first) expected.push_back(limited(one, query));
          expect_answers(octree, targets, query, expected);
          if (HasFatalFailure()) return;
        }
      }
    }
  }
}

/// Find of each target.
std::vector<std::vector<PointHit>> one_by_one(const Octree& octree, const std::vector<glm::dvec3>& targets,
                                              const PointQuery& query) {
  std::vector<std::vector<PointHit>> answers;
  for (const glm::dvec3& target : targets) answers.push_back(find(octree, target, query));
  return answers;
}

/// Squares of lengths below 1e-154 vanish: such points are all at distance 0, and the lowest ids are nearest.
TEST(NearTargets, distances_whose_squares_vanish_are_decided_by_id) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 100; ++i) positions.push_back(1e-165 * glm::dvec3(i, 2 * i % 7, 0));
  const PointCloud cloud = make_cloud(positions, {glm::dvec3(1e-165), glm::dvec3(0)});
  const std::vector<glm::dvec3> targets(8, positions.back());
  for (const std::size_t k : {1, 5}) {
    const PointQuery query{.k = k};
    const std::vector<PointHit> expected = brute_force::find(cloud, targets.front(), query);
    expect_answers(build(cloud), targets, query, {targets.size(), expected});
  }
}

/// Points are collected up to a reach, 1.15 times the distances found before: here 1.15, by the first target
/// alone. Of two points a little farther than that from the second target, the nearer one is not collected.
TEST(NearTargets, points_beyond_what_was_collected_are_found) {
  const std::vector<glm::dvec3> targets = {{-100, 0, 0}, {0, 0, 0}, {4, 0, 0}, {4, 0.1, 0}, {4, 0.2, 0}};
  const PointCloud cloud = make_cloud({{-101, 0, 0}, {1.15 + 4e-7, 0, 0}, {-1.15 - 2e-7, 0, 0}, {4, 1, 0}},
                                      {glm::dvec3(1e-7), glm::dvec3(0)});
  std::vector<std::vector<PointHit>> expected;
  for (const glm::dvec3& target : targets) expected.push_back(brute_force::find(cloud, target, {.k = 1}));
  EXPECT_EQ(expected[1][0].point_id, 2u);
  expect_answers(build(cloud), targets, {.k = 1}, expected);
}

TEST(NearTargets, answers_keep_to_the_coarse_levels_that_are_asked_for) {
  for (const PointFamily& family : point_families()) {
    Random random(family.name + "_levels");
    if (family.cloud.size() == 0) continue;
    const std::vector<glm::dvec3> targets = near_targets(family.cloud, random);
    for (const NamedOctree& named : octrees_of(family.cloud)) {
      if (named.octree.view().organisation != Organisation::layered) continue;
      for (int level = 0; level < 4; ++level) {
        const PointQuery query{.k = 5, .max_level = level};
        SCOPED_TRACE(family.name + ", " + named.name + ", level " + std::to_string(level));
        expect_answers(named.octree, targets, query, one_by_one(named.octree, targets, query));
      }
    }
  }
}

TEST(NearTargets, answers_are_the_same_on_any_number_of_threads_and_in_any_order) {
  const PointFamily family = point_families().back();
  const Octree octree = build(family.cloud);
  Random random("near_targets_on_threads");
  std::vector<glm::dvec3> targets;
  for (int i = 0; i < 10; ++i)
    std::ranges::copy(near_targets(family.cloud, random), std::back_inserter(targets));
  for (const PointQuery& query : {PointQuery{.k = 7}, PointQuery{.radius = 0.3, .k = 20}}) {
    std::vector<std::vector<PointHit>> expected = one_by_one(octree, targets, query);
    for (const std::size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      expect_answers(octree, targets, query, expected);
      std::ranges::reverse(targets);
      std::ranges::reverse(expected);
    }
  }
}

TEST(NearTargets, columns_hold_answers_with_filters_and_with_many_neighbours) {
  const PointFamily family = point_families()[3];
  const Octree octree = build(family.cloud);
  Random random("near_targets_in_columns");
  std::vector<glm::dvec3> targets = near_targets(family.cloud, random);
  targets.resize(100);
  const auto is_even = [](const Candidate& point) { return point.point_id % 2 == 0; };
  for (const PointQuery& query :
       {PointQuery{.k = 5, .filter = is_even}, PointQuery{.k = 100}, PointQuery{.radius = 0.2, .k = 100}}) {
    std::vector<std::vector<PointHit>> expected;
    for (const glm::dvec3& target : targets)
      expected.push_back(brute_force::find(family.cloud, target, query));
    expect_columns(octree, targets, query, expected);
  }
  expect_columns(Octree(), targets, {.k = 3}, {targets.size(), std::vector<PointHit>()});
  expect_columns(octree, {}, {.k = 3}, {});
}

TEST(NearTargets, of_more_than_a_million_targets_are_in_their_rows) {
  constexpr std::size_t k_sorted_at_once = std::size_t{1} << 20;
  const PointCloud cloud = make_cloud({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {glm::dvec3(0.01), glm::dvec3(0)});
  std::vector<glm::dvec3> targets(k_sorted_at_once + 5);
  for (std::size_t i = 0; i < targets.size(); ++i) targets[i] = {static_cast<double>(i % 3), 0.0, 0.1};
  std::vector<std::int64_t> ids(targets.size());
  std::vector<double> distances(targets.size());
  std::uint64_t last = 0;
  find(build(cloud), targets, {.k = 1}, {ids.data(), distances.data()},
       [&](std::uint64_t done, std::uint64_t) { return (last = done) > 0; });
  EXPECT_EQ(last, targets.size());
  for (std::size_t i = 0; i < targets.size(); ++i) ASSERT_EQ(ids[i], static_cast<std::int64_t>(i % 3)) << i;
}

TEST(NearTargets, in_columns_require_a_k_and_numbers) {
  const Octree octree = build(point_families()[3].cloud);
  std::vector<glm::dvec3> targets(3000, glm::dvec3(0.0));
  std::vector<std::int64_t> ids(100 * targets.size());
  std::vector<double> distances(ids.size());
  const PointHitColumns columns{ids.data(), distances.data()};
  EXPECT_THROW(find(octree, targets, {.radius = 1.0}, columns), Error);
  targets[2900].y = std::numeric_limits<double>::quiet_NaN();
  for (const std::size_t k : {3, 100}) {
    try {
      find(octree, targets, {.k = k}, columns);
      ADD_FAILURE() << "no error";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("point 2900"), std::string::npos) << error.what();
    }
  }
}

TEST(NearTargets, in_columns_report_progress_and_can_be_cancelled) {
  const Octree octree = build(point_families()[3].cloud);
  const std::vector<glm::dvec3> targets(5000, glm::dvec3(0.5));
  std::vector<std::int64_t> ids(70 * targets.size());
  std::vector<double> distances(ids.size());
  for (const std::size_t k : {3, 70}) {
    std::uint64_t last = 0;
    const auto watch = [&](std::uint64_t done, std::uint64_t total) {
      EXPECT_EQ(total, targets.size());
      EXPECT_GE(done, last);
      last = done;
      return true;
    };
    find(octree, targets, {.k = k}, {ids.data(), distances.data()}, watch);
    EXPECT_EQ(last, targets.size());
    EXPECT_THROW(find(octree, targets, {.k = k}, {ids.data(), distances.data()},
                      [](std::uint64_t, std::uint64_t) { return false; }),
                 Cancelled);
  }
}

TEST(NearTargets, of_any_finite_coordinates_are_answered) {
  const PointFamily family = point_families()[3];
  const Octree octree = build(family.cloud);
  const std::vector<glm::dvec3> targets{glm::dvec3(1e308), glm::dvec3(-1e308), glm::dvec3(0.0),
                                        glm::dvec3(0.0),   glm::dvec3(5e-324), glm::dvec3(1e30)};
  for (const PointQuery& query : {PointQuery{.k = 3}, PointQuery{.radius = 1e308, .k = 3}}) {
    std::vector<std::vector<PointHit>> expected;
    for (const glm::dvec3& target : targets)
      expected.push_back(brute_force::find(family.cloud, target, query));
    expect_answers(octree, targets, query, expected);
  }
}

TEST(NearTargets, of_clouds_far_beyond_what_floats_hold_are_answered) {
  Random random("far_cloud");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 34; ++i)
    positions.push_back(2.0 * glm::dvec3(random.unit(), random.unit(), random.unit()));
  PointCloud cloud = make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0.0)});
  for (const double offset : {1e20, 1e36, 3e39, 1e45, 1e300}) {
    cloud.lattice.offset = glm::dvec3(offset);
    const std::vector<glm::dvec3> targets(8, cloud.world(0));
    const PointQuery query{.k = 3};
    const std::vector<std::vector<PointHit>> expected(targets.size(),
                                                      brute_force::find(cloud, targets[0], query));
    expect_answers(build(cloud), targets, query, expected);
  }
}

TEST(NearTargets, whose_neighbours_are_too_many_to_collect_are_answered) {
  // A dense heap in a sparse plane: the reach of the plane's points holds too many of the heap's.
  std::vector<glm::dvec3> positions;
  Random random("heap_in_a_plane");
  for (int i = 0; i < 10000; ++i) positions.push_back(glm::dvec3(5.0) + 0.01 * random.in_cube());
  for (int i = 0; i < 1000; ++i) positions.push_back(10.0 * glm::dvec3(random.unit(), random.unit(), 0.5));
  const PointCloud cloud = make_cloud(positions, {glm::dvec3(0.0001), glm::dvec3(0.0)});
  const Octree octree = build(cloud);
  std::vector<glm::dvec3> targets;
  for (std::size_t i = 0; i < cloud.size(); i += i < 10000 ? 100 : 1) targets.push_back(cloud.world(i));
  for (const std::size_t k : {1, 10, 64}) {
    const PointQuery query{.k = k};
    std::vector<std::vector<PointHit>> expected;
    for (const glm::dvec3& target : targets) expected.push_back(brute_force::find(cloud, target, query));
    expect_answers(octree, targets, query, expected);
  }
}

}  // namespace
}  // namespace alidade
