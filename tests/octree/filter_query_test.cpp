// SPDX-License-Identifier: MIT
#include <atomic>

#include "octree/distance.h"
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

class Filter : public ::testing::Test {
 protected:
  Filter() : family_(point_families().back()), octree_(build(family_.cloud)) {}

  const PointFamily family_;
  const Octree octree_;
  Random random_;
};

TEST_F(Filter, is_asked_only_for_points_that_meet_all_other_conditions) {
  std::size_t calls = 0;
  for (const FindRayCase& c : find_ray_cases(family_.cloud, 200, random_)) {
    RayQuery query = c.query;
    query.filter = [&](const Candidate& point) {
      ++calls;
      const RayProjection expected = project(c.target, family_.cloud.world(point.point_id));
      EXPECT_EQ(point.position, family_.cloud.world(point.point_id));
      EXPECT_EQ(point.t, expected.t);
      EXPECT_EQ(point.distance, expected.distance);
      EXPECT_LE(point.distance, query.radius);
      EXPECT_GE(point.t, c.target.t_min);
      EXPECT_LE(point.t, c.target.t_max);
      EXPECT_GE(entry(expected, query.radius), query.entry_min);
      EXPECT_EQ(point.query_index, 0u);
      return point.point_id % 2 == 0;
    };
    (void)find(octree_, c.target, query);
    (void)closest(octree_, c.target, query);
    (void)occluded(octree_, c.target, query);
    (void)count(octree_, c.target, query);
    if (HasFailure()) return;
  }
  EXPECT_GT(calls, 1000u);
}

TEST_F(Filter, lets_closest_pass_what_it_rejects_and_take_the_next) {
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  const Octree octree = build(three_points());
  RayQuery query{.radius = 1.0};
  query.filter = [](const Candidate& point) { return point.point_id != 1; };
  EXPECT_EQ(closest(octree, ray, query)->point_id, 0u);
  query.filter = [](const Candidate& point) { return point.point_id == 2; };
  EXPECT_EQ(closest(octree, ray, query)->point_id, 2u);
  query.filter = [](const Candidate&) { return false; };
  EXPECT_FALSE(closest(octree, ray, query));
  EXPECT_FALSE(occluded(octree, ray, query));
}

TEST_F(Filter, sees_equal_points_apart) {
  // Of many points at one position only the last one counts.
  const std::size_t count_there = 3000;
  const PointCloud cloud = make_cloud(std::vector<glm::dvec3>(count_there, glm::dvec3(1, 0, 0)),
                                      {glm::dvec3(0.001), glm::dvec3(0)});
  const Octree octree = build(cloud);
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  RayQuery query{.radius = 0.5};
  query.filter = [&](const Candidate& point) { return point.point_id == count_there - 1; };
  EXPECT_EQ(closest(octree, ray, query)->point_id, count_there - 1);
  EXPECT_TRUE(occluded(octree, ray, query));
  EXPECT_EQ(count(octree, ray, {.radius = 0.5}), count_there);
  EXPECT_EQ(find(octree, ray, {.radius = 0.5, .k = 40}).back().point_id, 39u);
}

/// Clusters of equal points among others, in no order.
PointCloud clusters(Random& random) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 12000; ++i)
    positions.push_back(i % 2 == 0 ? 4.0 * random.in_cube()
                                   : glm::dvec3(static_cast<double>(random.below(4)), 0.5, 0.25));
  return make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
}

/// Towards a cluster, from anywhere.
std::vector<Ray> rays_to_clusters(std::size_t count, Random& random) {
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const glm::dvec3 from = 8.0 * random.direction(),
                     to = glm::dvec3(static_cast<double>(random.below(4)), 0.5, 0.25) +
                          0.02 * random.in_cube();
    rays.push_back(make_ray(from, to - from, 0.0));
  }
  return rays;
}

TEST_F(Filter, of_position_gives_the_answers_of_brute_force) {
  const PointCloud cloud = clusters(random_);
  // A batch of so many goes through the tree together.
  const std::vector<Ray> rays = rays_to_clusters(2500, random_);
  std::vector<RayQuery> queries(3, {.radius = 0.05, .measure = Measure::t});
  // The first cluster that a ray meets may count or not.
  for (RayQuery& query : queries)
    query.filter.of_position = [](const Candidate& point) {
      return point.query_index % 2 == 0 || point.position.x < 1.5;
    };
  queries[1].filter.of_point = [](const Candidate& point) { return point.point_id % 500 == 1; };
  queries[2].measure = Measure::entry;
  queries[2].filter.of_point = [](const Candidate& point) { return point.query_index % 3 != 0; };
  for (const NamedOctree& named : octrees_of(cloud)) {
    for (const RayQuery& query : queries) {
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(named.octree, rays, query, hits);
      occluded(named.octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); i += 7) {
        // Alone, its index is 0.
        RayQuery alone = query;
        const auto at = [i](const CandidateFilter::Function& filter) -> CandidateFilter::Function {
          if (!filter) return {};
          return [filter, i](Candidate point) {
            point.query_index = i;
            return filter(point);
          };
        };
        alone.filter.of_point = at(query.filter.of_point);
        alone.filter.of_position = at(query.filter.of_position);
        const std::optional<Hit> expected = brute_force::closest(cloud, rays[i], alone);
        ASSERT_TRUE(same_hits(hits[i], expected)) << named.name << ", ray " << i;
        ASSERT_EQ(blocked[i] != 0, expected.has_value()) << named.name << ", ray " << i;
      }
    }
  }
}

TEST_F(Filter, of_position_is_called_for_a_few_of_many_equal_points) {
  constexpr std::size_t k_equal = 100'000, k_rays = 3000, k_few = 300;
  std::vector<glm::dvec3> positions(k_equal, glm::dvec3(1, 0, 0));
  for (int i = 0; i < 1000; ++i) positions.push_back(glm::dvec3(3, 0, 0) + random_.in_cube());
  const PointCloud cloud = make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
  const Octree octree = build(cloud);
  const std::vector<Ray> rays(k_rays, make_ray({0, 0, 0}, {1, 0, 0}, 0.0));
  for (const Measure measure : {Measure::t, Measure::entry}) {
    for (const bool has_ids : {false, true}) {
      std::atomic<std::size_t> called = 0;
      RayQuery query{.radius = 0.5, .measure = measure};
      query.filter.of_position = [&](const Candidate& point) {
        ++called;
        return point.position.x > 1.5;
      };
      if (has_ids) query.filter.of_point = [](const Candidate& point) { return point.point_id >= k_equal; };
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      EXPECT_LT(called, 2 * k_rays * k_few);
      for (std::size_t i = 0; i < k_rays; ++i) ASSERT_EQ(blocked[i] != 0, hits[i].has_value());
      called = 0;
      EXPECT_TRUE(same_hits(closest(octree, rays[0], query), hits[0]));
      EXPECT_LT(called, k_few);
    }
  }
}

TEST_F(Filter, sees_t_0_for_points_boxes_and_half_spaces_and_the_distance_answers_have) {
  const auto check = [&](const auto& target) {
    PointQuery query;
    std::vector<Candidate> candidates;
    query.filter = [&](const Candidate& point) {
      candidates.push_back(point);
      return true;
    };
    const std::vector<PointHit> hits = find(octree_, target, query);
    EXPECT_EQ(candidates.size(), hits.size());
    for (const PointHit& hit : hits) {
      const auto same = [&](const Candidate& point) {
        return point.point_id == hit.point_id && point.t == 0.0 && point.distance == hit.distance;
      };
      ASSERT_TRUE(std::ranges::any_of(candidates, same));
    }
  };
  const glm::dvec3 center = octree_.bounds().center();
  check(Bounds{center - 2.0, center + 2.0});
  check(make_slab(make_plane(center, {1, 0, 0}), 1.0));
}

TEST_F(Filter, that_throws_ends_the_query_with_its_exception) {
  RayQuery query{.radius = 1.0};
  query.filter = [](const Candidate&) -> bool { throw std::runtime_error("by the caller"); };
  const Ray ray = make_ray(octree_.bounds().center(), {1, 0, 0});
  EXPECT_THROW((void)find(octree_, ray, query), std::runtime_error);
  const std::vector<Ray> rays(600, ray);
  EXPECT_THROW((void)find(octree_, rays, query), std::runtime_error);
}

}  // namespace
}  // namespace alidade
