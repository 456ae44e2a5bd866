// SPDX-License-Identifier: MIT
// Bounds over a box against the values of points inside it: never beyond, to the last bit.
#include <gtest/gtest.h>

#include "octree/path_index.h"
#include "octree/query_targets.h"
#include "tests/support/point_families.h"
#include "tests/support/positions.h"
#include "tests/support/query_families.h"
#include "tests/support/ray_families.h"

namespace alidade {
namespace {

using namespace test;

/// Calls check(random, box, points): small boxes around a few points of every family.
template <class Check>
void for_boxes_of_points(const Check& check) {
  for (const PointFamily& family : point_families()) {
    if (family.cloud.size() == 0) continue;
    Random random("boxes " + family.name);
    SCOPED_TRACE("seed \"boxes " + family.name + "\"");
    for (int i = 0; i < 150; ++i) {
      std::vector<glm::dvec3> points{family.cloud.world(random.below(family.cloud.size()))};
      const Positions positions(family.cloud, random);
      const double reach = positions.length();
      Bounds box;
      box.grow(points[0]);
      for (int n = 0; n < 8; ++n) {
        points.push_back(random.below(3) ? points[0] + reach * random.in_cube() : points[0]);
        box.grow(points.back());
      }
      // Corners are where bounds are reached.
      for (int corner = 0; corner < 8; ++corner) {
        points.push_back({corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                          corner & 4 ? box.max.z : box.min.z});
      }
      check(family.cloud, random, box, points);
      if (::testing::Test::HasFailure()) return;
    }
  }
}

TEST(DistanceBounds, projection_on_a_ray_holds_every_point_to_the_last_bit) {
  for_boxes_of_points([](const PointCloud& cloud, Random& random, const Bounds& box, const auto& points) {
    for (const RayCase& c : ray_cases(cloud, 10, random)) {
      const RayReach reach = project(c.ray, box);
      const double sphere = sphere_distance(c.ray, box);
      for (const glm::dvec3& point : points) {
        const RayProjection at = project(c.ray, point);
        ASSERT_LE(reach.t.low, at.t) << describe(c.ray);
        ASSERT_GE(reach.t.high, at.t) << describe(c.ray);
        ASSERT_LE(reach.distance.low, at.distance) << describe(c.ray);
        ASSERT_GE(reach.distance.high, at.distance) << describe(c.ray);
        ASSERT_LE(sphere, at.distance) << describe(c.ray);
      }
    }
  });
}

TEST(DistanceBounds, distances_to_points_and_planes_hold_every_point_to_the_last_bit) {
  for_boxes_of_points([](const PointCloud& cloud, Random& random, const Bounds& box, const auto& points) {
    const Positions positions(cloud, random);
    for (int i = 0; i < 10; ++i) {
      const glm::dvec3 from = positions.anywhere();
      const Plane plane = make_plane(from, random.direction());
      for (const glm::dvec3& point : points) {
        ASSERT_LE(distance(from, box).low, distance(from, point));
        ASSERT_GE(distance(from, box).high, distance(from, point));
        ASSERT_LE(signed_distance(plane, box).low, signed_distance(plane, point));
        ASSERT_GE(signed_distance(plane, box).high, signed_distance(plane, point));
      }
    }
  });
}

TEST(DistanceBounds, entry_never_falls_when_t_or_distance_grow) {
  Random random;
  for (int i = 0; i < 20000; ++i) {
    const double radius = std::pow(10.0, random.between(-3, 3)), t = random.between(-1e6, 1e6);
    const double first = radius * random.unit(), second = std::nextafter(first, 2 * radius);
    ASSERT_LE(entry({t, first}, radius), entry({t, second}, radius));
    ASSERT_LE(entry({t, first}, radius), entry({std::nextafter(t, 2e6), first}, radius));
  }
}

TEST(DistanceBounds, projection_on_a_segment_and_reach_of_a_path_hold_every_point) {
  for_boxes_of_points([](const PointCloud& cloud, Random& random, const Bounds& box, const auto& points) {
    for (const PathCase& c : path_cases(cloud, 2, random)) {
      const std::vector<Segment> segments = segments_of(c.target);
      const PathIndex index(c.target);
      const RayReach whole = index.reach(box, k_unlimited_radius);
      const RayReach near = index.reach(box, c.query.radius);
      for (const glm::dvec3& point : points) {
        for (const Segment& segment : segments) {
          const RayReach reach = project(segment, box);
          const RayProjection at = project(segment, point);
          ASSERT_LE(reach.t.low, at.t);
          ASSERT_GE(reach.t.high, at.t);
          ASSERT_LE(reach.distance.low, at.distance);
          ASSERT_GE(reach.distance.high, at.distance);
        }
        const PathProjection at = project(segments, point);
        ASSERT_LE(whole.distance.low, at.distance);
        ASSERT_LE(whole.t.low, at.t);
        ASSERT_GE(whole.t.high, at.t);
        if (!(at.distance <= c.query.radius)) continue;
        ASSERT_LE(near.distance.low, at.distance);
        ASSERT_LE(near.t.low, at.t);
        ASSERT_GE(near.t.high, at.t);
      }
    }
  });
}

TEST(DistanceBounds, the_index_of_a_path_finds_the_nearest_position_to_the_last_bit) {
  for (const PointFamily& family : point_families()) {
    Random random("path index " + family.name);
    const Positions positions(family.cloud, random);
    for (const PathCase& c : path_cases(family.cloud, 40, random)) {
      const std::vector<Segment> segments = segments_of(c.target);
      const PathIndex index(c.target);
      for (int i = 0; i < 20; ++i) {
        // Vertices are where segments tie.
        const glm::dvec3 point =
            i % 5 ? positions.anywhere() : c.target.vertices[random.below(c.target.vertices.size())];
        const PathProjection expected = project(segments, point), found = index.project(point);
        ASSERT_EQ(found.segment, expected.segment) << family.name << " " << describe(c.target);
        ASSERT_EQ(found.t, expected.t) << family.name;
        ASSERT_EQ(found.distance, expected.distance) << family.name;
      }
    }
  }
}

TEST(DistanceBounds, the_index_of_a_path_allows_for_the_rounding_of_distances) {
  // Segments almost along an axis: the box around them is as near as they are, so a bound that allowed for no
  // rounding would discard the nearest segment itself.
  Random random;
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 start = 1000.0 * random.in_cube();
    const double tilt = std::pow(10.0, random.between(-15, -9));
    const glm::dvec3 way = glm::dvec3(random.between(1, 100), 0, 0) + tilt * random.in_cube();
    const Path path = make_path({start, start + way});
    const PathIndex index(path);
    const glm::dvec3 point =
        start + random.unit() * way + std::pow(10.0, random.between(-3, 3)) * glm::dvec3(0, random.unit(), 1);
    const PathProjection at = project(segments_of(path), point);
    ASSERT_EQ(index.project(point).distance, at.distance);
    const RayReach reach = index.reach({point, point}, k_unlimited_radius);
    ASSERT_LE(reach.distance.low, at.distance) << i;
    ASSERT_LE(reach.t.low, at.t);
    ASSERT_GE(reach.t.high, at.t);
  }
}

TEST(DistanceBounds, numbers_that_overflow_discard_nothing) {
  const Bounds box{{-1e308, -1e308, -1e308}, {1e308, 1e308, 1e308}};
  const Ray ray = make_ray({1e308, -1e308, 0}, {1, 1, -1});
  const RayQuery query{.measure = Measure::t};
  const RayTarget target(ray, query);
  for (const DistanceBound bound : {DistanceBound::none, DistanceBound::sphere, DistanceBound::box}) {
    EXPECT_FALSE(target.too_far(target.reach(box, bound)));
    EXPECT_FALSE(target.outside_interval(target.reach(box, bound)));
  }
}

}  // namespace
}  // namespace alidade
