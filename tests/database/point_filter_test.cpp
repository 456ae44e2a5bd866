// SPDX-License-Identifier: MIT
// Pruning never loses a point: bounds hold what points inside give, to the last bit.
#include "database/point_filter.h"

#include <gtest/gtest.h>

#include "octree/distance.h"
#include "tests/support/random.h"

namespace alidade {

using namespace database;

namespace {

class Cases {
 public:
  explicit Cases(const char* name) : random_(name) {}

  Bounds box() {
    const double size = choose({0.0, 1e-3, 1.0, 100.0});
    const glm::dvec3 low(position());
    return {low, low + glm::dvec3(random_.unit(), random_.unit(), random_.unit()) * size};
  }
  glm::dvec3 inside(const Bounds& box) {
    // Corners and faces as often as what lies between.
    const auto along = [&](int axis) {
      const double share = choose({0.0, 1.0, random_.unit()});
      return std::clamp(box.min[axis] + share * (box.max[axis] - box.min[axis]), box.min[axis],
                        box.max[axis]);
    };
    return {along(0), along(1), along(2)};
  }
  glm::dvec3 position() {
    const double reach = choose({1.0, 200.0, 1e6});
    const glm::dvec3 centre = choose({0.0, 1.0}) * glm::dvec3(690000, 5325000, 400);
    return centre + glm::dvec3(random_.between(-reach, reach), random_.between(-reach, reach),
                               random_.between(-reach, reach));
  }
  glm::dvec3 direction() {
    while (true) {
      glm::dvec3 direction;
      for (int axis = 0; axis < 3; ++axis)
        direction[axis] = choose({0.0, 1.0, -1.0, random_.between(-1, 1), 1e-200, -1e-300});
      if (direction != glm::dvec3(0.0)) return direction;
    }
  }
  double unit() { return random_.unit(); }

 private:
  double choose(std::initializer_list<double> values) { return values.begin()[random_.below(values.size())]; }

  test::Random random_;
};

TEST(PointFilter, no_box_is_pruned_that_has_a_match) {
  Cases cases("point filter");
  int tight = 0, pruned = 0;
  for (int i = 0; i < 200000; ++i) {
    const Bounds box = cases.box();
    const glm::dvec3 point = cases.inside(box);
    const Ray ray = make_ray(cases.position(), cases.direction());
    const Plane plane = make_plane(cases.position(), cases.direction());
    const RayProjection at = project(ray, point);
    const double height = signed_distance(plane, point);
    // Limits that the point just keeps.
    const PointFilter kept{.lines = {{ray, {at.distance, at.distance}, {at.t, at.t}}},
                           .planes = {{plane, {height, height}}},
                           .box = box};
    ASSERT_TRUE(holds(kept, point)) << i;
    ASSERT_TRUE(may_hold(kept, box)) << i;
    ASSERT_TRUE(may_hold(kept, Bounds{point, point})) << i;
    ++tight;
    // Limits that the point may keep or not.
    const PointFilter any{.lines = {{ray, {-1.0, 50.0 * cases.unit()}, {0.0, 1e9}}}};
    if (!may_hold(any, box)) {
      ++pruned;
      ASSERT_FALSE(holds(any, point)) << i;
    }
  }
  EXPECT_GT(pruned, 1000);
  EXPECT_EQ(tight, 200000);
}

TEST(PointFilter, limits_that_no_number_keeps_hold_for_nothing) {
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  const Bounds box{{0, 0, 0}, {1, 1, 1}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Interval limits : {Interval{2, 1}, Interval{nan, 1}, Interval{0, nan}}) {
    const PointFilter filter{.lines = {{.ray = ray, .distance = limits}}};
    EXPECT_FALSE(may_hold(filter, box));
    EXPECT_FALSE(holds(filter, glm::dvec3(0.5)));
  }
  EXPECT_TRUE(may_hold({}, box));
  EXPECT_TRUE(holds({}, glm::dvec3(0.5)));
}

TEST(PointFilter, all_conditions_must_hold) {
  const Ray ray = make_ray({0, 0, 0}, {1, 0, 0});
  const Plane plane = make_plane({5, 0, 0}, {1, 0, 0});
  const PointFilter filter{.lines = {{.ray = ray, .distance = {-1, 1}}}, .planes = {{plane, {0, 2}}}};
  EXPECT_TRUE(holds(filter, {6, 0.5, 0}));
  EXPECT_FALSE(holds(filter, {6, 1.5, 0}));
  EXPECT_FALSE(holds(filter, {8, 0.5, 0}));
  EXPECT_FALSE(may_hold(filter, {{0, 0, 0}, {4, 1, 1}}));
  EXPECT_FALSE(may_hold(filter, {{5, 2, 2}, {6, 3, 3}}));
  EXPECT_TRUE(may_hold(filter, {{0, 0, 0}, {5, 1, 1}}));
}

}  // namespace
}  // namespace alidade
