// SPDX-License-Identifier: MIT
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

constexpr double k_quarter_turn = 0.78539816339744830961;

TEST(ConeVsBruteForce, find_count_closest_and_occluded_are_the_same_bits_on_every_family) {
  const Tally tally = expect_as_brute_force_on_every_family(100, cone_cases);
  EXPECT_GT(tally.answers, 100000u);
  EXPECT_GT(tally.empty, 300u);
  EXPECT_GT(tally.cases - tally.empty, 500u);
}

TEST(Cone, its_limit_grows_with_t) {
  const Octree octree =
      build(make_cloud({{10, 1, 0}, {20, 1, 0}, {20, 3, 0}}, {glm::dvec3(0.001), glm::dvec3(0)}));
  const Cone cone{make_ray({0, 0, 0}, {1, 0, 0}, 0.0), 0.0, 0.0625};
  EXPECT_EQ(ids_of(find(octree, cone)), (Ids{1}));
}

TEST(Cone, distance_equal_to_the_limit_counts) {
  const Octree octree = build(make_cloud({{16, 1, 0}}, {glm::dvec3(0.001), glm::dvec3(0)}));
  const Ray axis = make_ray({0, 0, 0}, {1, 0, 0}, 0.0);
  EXPECT_EQ(count(octree, Cone{axis, 0.0, 0.0625}), 1u);
  EXPECT_EQ(count(octree, Cone{axis, 0.0, std::nextafter(0.0625, 0.0)}), 0u);
}

TEST(Cone, with_slope_0_answers_as_a_ray_of_its_radius) {
  const PointFamily family = point_families().back();
  const Octree octree = build(family.cloud);
  Random random;
  for (const FindRayCase& c : find_ray_cases(family.cloud, 200, random)) {
    if (std::isinf(c.query.radius) || std::isfinite(c.query.entry_min)) continue;
    const ConeQuery query{.measure = c.query.measure, .k = c.query.k, .filter = c.query.filter};
    ASSERT_TRUE(
        same_hits(find(octree, Cone{c.target, c.query.radius, 0.0}, query), find(octree, c.target, c.query)));
  }
}

TEST(Cone, entry_uses_the_limit_at_the_projection) {
  const Octree octree = build(make_cloud({{16, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)}));
  const std::optional<Hit> hit = closest(octree, Cone{make_ray({0, 0, 0}, {1, 0, 0}), 1.0, 0.125});
  EXPECT_EQ(hit->entry, 16.0 - 3.0);
}

TEST(Cone, points_where_the_limit_is_negative_are_outside) {
  const Octree octree =
      build(make_cloud({{-5, 0, 0}, {-1, 0, 0}, {5, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)}));
  const Cone all_of_the_axis{make_ray({0, 0, 0}, {1, 0, 0}), 1.0, 0.5};
  EXPECT_EQ(ids_of(find(octree, all_of_the_axis, {.measure = Measure::t})), (Ids{1, 2}));
}

TEST(Cone, begins_at_the_apex_by_default) {
  const Octree octree = build(make_cloud({{-1, 0, 0}, {1, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0)}));
  EXPECT_EQ(ids_of(find(octree, make_cone({0, 0, 0}, {2, 0, 0}, k_quarter_turn, 3.0))), (Ids{1}));
  EXPECT_EQ(ids_of(find(octree, make_cone({0, 0, 0}, {2, 0, 0}, k_quarter_turn, 3.0, -2.0))), (Ids{0, 1}));
}

TEST(Cone, make_cone_takes_the_half_angle_in_radians) {
  const Cone cone = make_cone({0, 0, 0}, {0, 0, 7}, k_quarter_turn);
  EXPECT_NEAR(cone.slope, 1.0, 1e-15);
  EXPECT_EQ(cone.axis.direction, glm::dvec3(0, 0, 1));
  EXPECT_EQ(cone.axis.t_min, 0.0);
}

TEST(Cone, angles_and_radii_that_are_no_cones_are_errors) {
  const double nan = std::nan(""), infinity = HUGE_VAL;
  for (const double angle : {-1e-9, 1.5707963267948966, 2.0, nan, infinity})
    EXPECT_THROW(make_cone({0, 0, 0}, {1, 0, 0}, angle), Error) << angle;
  for (const double radius : {-1e-9, nan, infinity})
    EXPECT_THROW(make_cone({0, 0, 0}, {1, 0, 0}, 0.1, radius), Error) << radius;
  EXPECT_THROW(make_cone({0, 0, 0}, {0, 0, 0}, 0.1), Error);
  EXPECT_THROW(make_cone({nan, 0, 0}, {1, 0, 0}, 0.1), Error);
  EXPECT_THROW(make_cone({0, 0, 0}, {1, 0, 0}, 0.1, 0.0, nan), Error);
}

}  // namespace
}  // namespace alidade
