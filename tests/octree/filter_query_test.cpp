// SPDX-License-Identifier: MIT
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
  std::size_t asked = 0;
  for (const FindRayCase& c : find_ray_cases(family_.cloud, 200, random_)) {
    RayQuery query = c.query;
    query.filter = [&](const Candidate& point) {
      ++asked;
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
  EXPECT_GT(asked, 1000u);
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

TEST_F(Filter, sees_t_0_for_points_boxes_and_half_spaces_and_the_distance_answers_have) {
  const auto ask = [&](const auto& target) {
    PointQuery query;
    std::vector<Candidate> asked;
    query.filter = [&](const Candidate& point) {
      asked.push_back(point);
      return true;
    };
    const std::vector<PointHit> hits = find(octree_, target, query);
    EXPECT_EQ(asked.size(), hits.size());
    for (const PointHit& hit : hits) {
      const auto same = [&](const Candidate& point) {
        return point.point_id == hit.point_id && point.t == 0.0 && point.distance == hit.distance;
      };
      ASSERT_TRUE(std::ranges::any_of(asked, same));
    }
  };
  const glm::dvec3 center = octree_.bounds().center();
  ask(Bounds{center - 2.0, center + 2.0});
  ask(make_slab(make_plane(center, {1, 0, 0}), 1.0));
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
