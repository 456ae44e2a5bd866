// SPDX-License-Identifier: MIT
#include <tbb/global_control.h>

#include <atomic>
#include <limits>

#include "octree/check_query.h"
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

template <class Answer>
void expect_all_same(const Answers<Answer>& found, const std::vector<std::vector<Answer>>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  ASSERT_EQ(found.begin.front(), 0u);
  ASSERT_EQ(found.begin.back(), found.all.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_TRUE(same_hits(found[i], std::span<const Answer>(expected[i]))) << "target " << i;
  }
}

/// find and count of many targets against find of each, on one and more threads.
template <class Target, class Query>
void expect_as_one_by_one(const Octree& octree, const std::vector<QueryCase<Target, Query>>& cases,
                          const Query& query) {
  std::vector<Target> targets;
  for (const auto& c : cases) targets.push_back(c.target);
  std::vector<decltype(find(octree, targets[0], query))> expected;
  for (const Target& target : targets) expected.push_back(find(octree, target, query));
  for (const std::size_t threads : {1, 2, 5}) {
    SCOPED_TRACE(std::to_string(threads) + " threads");
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    expect_all_same(find(octree, std::span<const Target>(targets), query), expected);
    std::vector<std::size_t> counts(targets.size());
    count(octree, std::span<const Target>(targets), query, counts);
    for (std::size_t i = 0; i < targets.size(); ++i) ASSERT_EQ(counts[i], expected[i].size());
  }
}

void expect_closest_and_occluded(const Octree& octree, std::span<const Ray> rays, const RayQuery& query,
                                 const std::vector<std::optional<Hit>>& expected) {
  std::vector<std::optional<Hit>> hits(rays.size());
  std::vector<std::uint8_t> blocked(rays.size());
  closest(octree, rays, query, hits);
  occluded(octree, rays, query, blocked);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    ASSERT_TRUE(same_hits(hits[i], expected[i])) << "ray " << i;
    ASSERT_EQ(blocked[i] != 0, expected[i].has_value()) << "ray " << i;
  }
}

class Batch : public ::testing::Test {
 protected:
  Batch() : family_(point_families().back()), octree_(build(family_.cloud)) {}

  const PointFamily family_;
  const Octree octree_;
  Random random_;
};

// More targets than one task takes, so that the seams between tasks are among them.
constexpr std::size_t k_targets = 700;

TEST_F(Batch, of_rays_answers_in_the_order_of_the_rays_on_any_number_of_threads) {
  const auto cases = find_ray_cases(family_.cloud, k_targets, random_);
  expect_as_one_by_one(octree_, cases, RayQuery{.radius = 0.2});
  expect_as_one_by_one(octree_, cases, RayQuery{.radius = 0.5, .measure = Measure::t, .k = 3});
  expect_as_one_by_one(octree_, cases, RayQuery{.measure = Measure::distance, .k = 8});
}

TEST_F(Batch, of_rays_gives_closest_and_occluded_in_the_order_of_the_rays) {
  std::vector<Ray> rays;
  for (const FindRayCase& c : find_ray_cases(family_.cloud, 2000, random_)) rays.push_back(c.target);
  const CandidateFilter odd = [](const Candidate& point) { return point.point_id % 2 == 1; };
  for (const RayQuery& query :
       {RayQuery{.radius = 0.2}, RayQuery{.radius = 0.2, .measure = Measure::t, .filter = odd},
        RayQuery{.measure = Measure::distance}, RayQuery{.radius = 0.3, .entry_min = 1e-6}}) {
    std::vector<std::optional<Hit>> expected;
    for (const Ray& ray : rays) expected.push_back(closest(octree_, ray, query));
    for (const std::size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      expect_closest_and_occluded(octree_, rays, query, expected);
    }
  }
}

TEST_F(Batch, of_many_rays_that_start_here_and_there_answers_in_their_order) {
  // So many that they are sorted; among them rays that lanes do not answer and far away ones.
  std::vector<Ray> rays;
  for (const FindRayCase& c : find_ray_cases(family_.cloud, 55000, random_)) rays.push_back(c.target);
  for (std::size_t i = 0; i < rays.size(); i += 1000) {
    rays[i].direction *= 1.0 + 1e-9;
    rays[i + 1].origin += glm::dvec3(1e9, 0, 0);
  }
  const CandidateFilter odd = [](const Candidate& point) { return point.query_index % 2 == 1; };
  for (const RayQuery& query :
       {RayQuery{.radius = 0.2}, RayQuery{.radius = 0.2, .measure = Measure::t, .filter = odd}}) {
    std::vector<std::optional<Hit>> expected;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      expected.push_back(closest(octree_, rays[i], {.radius = query.radius, .measure = query.measure}));
      if (query.filter && i % 2 == 0) expected.back().reset();
    }
    for (const std::size_t threads : {1, 2, 5}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      expect_closest_and_occluded(octree_, rays, query, expected);
    }
  }
  rays[41000].t_max = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::optional<Hit>> hits(rays.size());
  try {
    closest(octree_, rays, {.radius = 0.2}, hits);
    FAIL() << "a ray without an interval was accepted";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("ray 41000"), std::string::npos) << error.what();
  }
}

TEST_F(Batch, of_cones_paths_regions_boxes_and_points_answers_in_their_order) {
  expect_as_one_by_one(octree_, cone_cases(family_.cloud, k_targets, random_), ConeQuery{.k = 5});
  expect_as_one_by_one(octree_, path_cases(family_.cloud, k_targets, random_), PathQuery{.radius = 0.5});
  expect_as_one_by_one(octree_, region_cases(family_.cloud, k_targets, random_), PointQuery{.k = 9});
  expect_as_one_by_one(octree_, box_cases(family_.cloud, k_targets, random_), PointQuery{.k = 100});
  expect_as_one_by_one(octree_, point_cases(family_.cloud, k_targets, random_), PointQuery{.k = 8});
}

TEST_F(Batch, of_nothing_answers_nothing) {
  const Answers<Hit> none = find(octree_, std::span<const Ray>(), {.radius = 1.0});
  EXPECT_EQ(none.size(), 0u);
  EXPECT_TRUE(none.all.empty());
  std::vector<std::optional<Hit>> hits;
  closest(octree_, std::span<const Ray>(), {.radius = 1.0}, hits);
}

/// A filter that admits points to every second target only.
template <class Target, class Query>
void expect_every_second_answered(const Octree& octree, const std::vector<QueryCase<Target, Query>>& cases,
                                  Query query) {
  std::vector<Target> targets;
  for (const auto& c : cases) targets.push_back(c.target);
  const std::span<const Target> span(targets);
  const auto all = find(octree, span, query);
  query.filter = [](const Candidate& point) { return point.query_index % 2 == 1; };
  const auto odd = find(octree, span, query);
  std::vector<std::size_t> counts(targets.size());
  count(octree, span, query, counts);
  std::vector<std::optional<Hit>> hits(targets.size());
  std::vector<std::uint8_t> blocked(targets.size());
  if constexpr (std::is_same_v<Target, Ray>) {
    closest(octree, span, query, hits);
    occluded(octree, span, query, blocked);
  }
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const std::size_t expected = i % 2 ? all[i].size() : 0;
    ASSERT_EQ(odd[i].size(), expected);
    ASSERT_EQ(counts[i], expected);
    if constexpr (std::is_same_v<Target, Ray>) {
      ASSERT_EQ(hits[i].has_value(), expected > 0);
      ASSERT_EQ(blocked[i] != 0, expected > 0);
    }
  }
  EXPECT_GT(odd.all.size(), 100u);
}

TEST_F(Batch, in_which_several_targets_fail_tells_of_the_first_on_any_number_of_threads) {
  const std::vector<glm::dvec3> sound(20000);
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto problem = [](std::span<const glm::dvec3> targets) -> std::string {
      try {
        for_each_range(targets, 4, [](std::size_t first, std::size_t last) {
          for (std::size_t i = first; i < last; ++i)
            if (i >= 5000 && i % 7 == 3) throw Error({.problem = "work on " + std::to_string(i)});
        });
      } catch (const Error& error) {
        return error.what();
      }
      return "none";
    };
    EXPECT_EQ(problem(sound), "work on 5001");
    std::vector<glm::dvec3> bad = sound;
    bad[19000].x = bad[4321].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(problem(bad).substr(0, 11), "point 4321:");
  }
}

TEST_F(Batch, its_filter_is_told_the_number_of_the_target) {
  expect_every_second_answered(octree_, find_ray_cases(family_.cloud, k_targets, random_),
                               RayQuery{.radius = 0.3});
  expect_every_second_answered(octree_, cone_cases(family_.cloud, k_targets, random_), ConeQuery{.k = 5});
  expect_every_second_answered(octree_, path_cases(family_.cloud, k_targets, random_),
                               PathQuery{.radius = 0.5});
  expect_every_second_answered(octree_, region_cases(family_.cloud, k_targets, random_), PointQuery{.k = 9});
  expect_every_second_answered(octree_, box_cases(family_.cloud, k_targets, random_), PointQuery{.k = 9});
  expect_every_second_answered(octree_, point_cases(family_.cloud, k_targets, random_), PointQuery{.k = 9});
}

}  // namespace
}  // namespace alidade
