// SPDX-License-Identifier: MIT
#include "simulation/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

#include "tests/support/random.h"

namespace alidade::simulation::shapes {
namespace {

using glm::dmat3;
using glm::dvec2;
using glm::dvec3;

std::optional<double> shoot(const Shape& shape, const dvec3& origin, const dvec3& direction,
                            double t_min = 0.0, double t_max = 1e9) {
  return intersect(shape, make_ray(origin, direction, t_min, t_max));
}

dmat3 some_axes() {
  const dvec3 x = glm::normalize(dvec3(2, 1, 0.5)), z = glm::normalize(glm::cross(x, dvec3(0, 1, 3)));
  return {x, glm::cross(z, x), z};
}

TEST(Sphere, MeetsTheClosedForm) {
  const Sphere sphere{{1, 2, 3}, 2.0};
  EXPECT_DOUBLE_EQ(*shoot(sphere, {1, 2, 13}, {0, 0, -1}), 8.0);
  EXPECT_DOUBLE_EQ(*shoot(sphere, {1, 2, 3}, {0, 1, 0}), 2.0);             // from inside
  EXPECT_DOUBLE_EQ(*shoot(sphere, {1, 3.2, 13}, {0, 0, -1}), 10.0 - 1.6);  // 3-4-5 triangle
  EXPECT_DOUBLE_EQ(*shoot(sphere, {1, 2, 13}, {0, 0, -1}, 8.5),
                   12.0);  // the far side, when the near one is too near
  EXPECT_FALSE(shoot(sphere, {1, 2, 13}, {0, 0, -1}, 0.0, 7.99));
  EXPECT_FALSE(shoot(sphere, {1, 4.001, 13}, {0, 0, -1}));
}

TEST(Sphere, IntervalLimitsAreInclusive) {
  const Sphere sphere{{0, 0, 0}, 1.0};
  EXPECT_EQ(shoot(sphere, {0, 0, 5}, {0, 0, -1}, 4.0, 4.0), 4.0);
  EXPECT_EQ(shoot(sphere, {0, 0, 5}, {0, 0, -1}, 6.0, 6.0), 6.0);
}

TEST(Sphere, IsMetPreciselyFromFarAway) {
  const Sphere sphere{{0, 0, 0}, 0.1};
  const double t = *shoot(sphere, {1e6, 0.06, 0}, {-1, 0, 0});
  EXPECT_NEAR(t, 1e6 - 0.08, 1e-9);
}

TEST(Disc, HasAHole) {
  const Disc ring{{0, 0, 1}, {0, 0, 1}, 2.0, 1.0};
  EXPECT_FALSE(shoot(ring, {0.5, 0, 5}, {0, 0, -1}));
  EXPECT_DOUBLE_EQ(*shoot(ring, {1.5, 0, 5}, {0, 0, -1}), 4.0);
  EXPECT_DOUBLE_EQ(*shoot(ring, {1.5, 0, -5}, {0, 0, 1}), 6.0);  // from below as well
  EXPECT_FALSE(shoot(ring, {2.5, 0, 5}, {0, 0, -1}));
  EXPECT_FALSE(shoot(ring, {1.5, 0, 1}, {1, 0, 0}));  // within its plane
}

TEST(Panel, OpeningsLetRaysThroughAndArchesAreRound) {
  const Panel wall{
      {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {10, 5}, {{{1, 1}, {3, 2}, false}, {{5, 0}, {7, 4}, true}}};
  const auto through = [&](double u, double v) { return !shoot(wall, {u, -4, v}, {0, 1, 0}); };
  EXPECT_DOUBLE_EQ(*shoot(wall, {0.5, -4, 0.5}, {0, 1, 0}), 4.0);
  EXPECT_TRUE(through(2, 1.5));
  EXPECT_FALSE(through(2, 2.01));
  EXPECT_TRUE(through(5.01, 2.99));  // below the spring of the arch, whose radius is 1
  EXPECT_FALSE(through(5.1, 3.9));
  EXPECT_TRUE(through(6 + 0.6, 3 + 0.79));
  EXPECT_FALSE(through(6 + 0.6, 3 + 0.81));
  EXPECT_TRUE(through(10.01, 1));
  EXPECT_TRUE(through(4, 5.01));
}

TEST(Niche, IsOpenTowardsItsFrontOnly) {
  const Niche niche{{{0, 0, 0}, dmat3(1.0), {1, 1, 0.25}}};
  EXPECT_DOUBLE_EQ(*shoot(niche, {0, 0, 3}, {0, 0, -1}), 3.25);  // to the pane
  EXPECT_DOUBLE_EQ(*shoot(niche, {0, 0, 3}, glm::normalize(dvec3(1, 0, -3))),
                   std::sqrt(10.0));                             // to the reveal
  EXPECT_DOUBLE_EQ(*shoot(niche, {0, 0, -3}, {0, 0, 1}), 2.75);  // its back
  EXPECT_FALSE(shoot(niche, {0, 0, 0}, {0, 0, 1}));              // out of it
  EXPECT_EQ(surface_at(niche, {0.2, 0.3, -0.25}).face, 4);
  EXPECT_EQ(surface_at(niche, {0.2, 0.3, -0.25}).normal, dvec3(0, 0, 1));
  EXPECT_EQ(surface_at(niche, {1.0, 0.3, 0.1}).normal, dvec3(-1, 0, 0));
}

TEST(Polygon, CoversItsInsideOnly) {
  const Polygon triangle{{{0, 0, 0}, {4, 0, 0}, {0, 0, 4}}};
  EXPECT_DOUBLE_EQ(*shoot(triangle, {1, -2, 1}, {0, 1, 0}), 2.0);
  EXPECT_DOUBLE_EQ(*shoot(triangle, {1, 2, 1}, {0, -1, 0}), 2.0);
  EXPECT_TRUE(shoot(triangle, {1.99, -2, 2}, {0, 1, 0}));
  EXPECT_FALSE(shoot(triangle, {2.01, -2, 2}, {0, 1, 0}));
  EXPECT_FALSE(shoot(triangle, {-0.01, -2, 1}, {0, 1, 0}));
}

TEST(Frustum, VaultExistsOnItsKeptSideOnly) {
  const Frustum vault{{0, 0, 2}, {0, 1, 0}, 5.0, 1.5, 1.5, {0, 0, 1}};
  EXPECT_DOUBLE_EQ(*shoot(vault, {0, 2, 2}, {0, 0, 1}), 1.5);
  EXPECT_FALSE(shoot(vault, {0, 2, 2}, {0, 0, -1}));
  EXPECT_FALSE(shoot(vault, {0, 5.1, 2}, {0, 0, 1}));
}

TEST(Frustum, RaysAlongTheAxisOfACylinderMissItsMantle) {
  const Frustum tube{{0, 0, 0}, {0, 0, 1}, 2.0, 1.0, 1.0, dvec3(0.0)};
  EXPECT_FALSE(shoot(tube, {0.5, 0, 1}, {0, 0, 1}));
  EXPECT_FALSE(shoot(tube, {3, 0, 1}, {0, 0, 1}));
}

TEST(Frustum, ConeIsMetAlongItsAxisDirection) {
  const Frustum cone{{0, 0, 0}, {0, 0, 1}, 2.0, 1.0, 0.0, dvec3(0.0)};
  EXPECT_DOUBLE_EQ(*shoot(cone, {0.5, 0, 5}, {0, 0, -1}), 4.0);  // radius 0.5 is at height 1
  EXPECT_DOUBLE_EQ(*shoot(cone, {-3, 0, 0.5}, {1, 0, 0}), 2.25);
}

TEST(Ground, CoreIsThePlane) {
  const Ground ground{{60, 50}, {30, 25}, 20.0, {{1.0, {0.2, 0.1}, 0.5}}, {{{0, 0}, {2, 1}, true, 7}}};
  const dvec3 down = glm::normalize(dvec3(1, 0, -1));
  EXPECT_DOUBLE_EQ(*shoot(ground, {-3, 4, 1.7}, down), 1.7 * std::sqrt(2.0));
  EXPECT_EQ(surface_at(ground, {1, 0.5, 0}).face, 7);
  EXPECT_EQ(surface_at(ground, {1.9, 0.9, 0}).face, 0);
  EXPECT_FALSE(shoot(ground, {0, 0, 1}, {1, 0, 0.1}));
}

TEST(Ground, SlopeIsTheDerivativeOfTheHeight) {
  const Ground ground{{60, 50}, {30, 25}, 15.0, {{1.0, {0.2, 0.1}, 0.5}, {0.3, {-0.3, 0.5}, 1.0}}, {}};
  test::Random random;
  for (int i = 0; i < 2000; ++i) {
    const dvec2 position(random.between(-60, 60), random.between(-50, 50));
    const GroundHeight here = height_at(ground, position);
    constexpr double k_step = 1e-5;
    for (int axis = 0; axis < 2; ++axis) {
      dvec2 step(0.0);
      step[axis] = k_step;
      const double difference =
          (height_at(ground, position + step).height - height_at(ground, position - step).height) /
          (2 * k_step);
      EXPECT_NEAR(here.slope[axis], difference, 1e-8);
    }
  }
}

/// A shape together with an independent description of its surface: zero on it, and changing sign across it.
/// NaN where the description does not hold (beyond the ends of an open mantle).
struct Implicit {
  const char* name;
  Shape shape;
  std::function<double(const dvec3&)> value;
  dvec3 reach;  ///< rays start within twice this
};

std::vector<Implicit> implicits() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Box box{{0.3, -0.2, 0.5}, some_axes(), {1.0, 0.6, 1.7}};
  const Frustum cone{{0.1, 0.2, -1.0}, some_axes()[0], 3.0, 1.2, 0.4, dvec3(0.0)};
  const Frustum tube{{-0.4, 0.2, -1.0}, some_axes()[1], 2.5, 0.7, 0.7, dvec3(0.0)};
  const Ground ground{{60, 50},
                      {20, 10},
                      18.0,
                      {{0.75, {0.155, 0.060}, 0.7}, {0.45, {-0.090, 0.245}, 2.1}, {0.18, {0.43, 0.31}, 4.0}},
                      {}};
  ConvexSolid solid;
  for (const dvec3& normal : {dvec3(1, 0, 0), dvec3(-1, 0.2, 0), dvec3(0, 1, 0.3), dvec3(0.1, -1, 0),
                              dvec3(0, 0.2, 1), dvec3(0.3, 0, -1)})
    solid.sides.push_back({glm::normalize(normal), 1.0 + 0.3 * normal.x});
  solid.bounds = {dvec3(-3.0), dvec3(3.0)};
  const auto mantle = [nan](const Frustum& frustum) {
    return [frustum, nan](const dvec3& p) {
      const double height = glm::dot(p - frustum.base, frustum.axis);
      if (height < 0.0 || height > frustum.length) return nan;
      const double radius =
          frustum.base_radius + (frustum.top_radius - frustum.base_radius) * height / frustum.length;
      return glm::length(p - frustum.base - height * frustum.axis) - radius;
    };
  };
  return {
      {"sphere", Sphere{{0.5, -0.3, 0.2}, 1.1},
       [](const dvec3& p) { return glm::length(p - dvec3(0.5, -0.3, 0.2)) - 1.1; }, dvec3(2.0)},
      {"ellipsoid", Ellipsoid{{0.5, -0.3, 0.2}, {0.5, 1.0, 1.5}},
       [](const dvec3& p) { return glm::length((p - dvec3(0.5, -0.3, 0.2)) / dvec3(0.5, 1.0, 1.5)) - 1.0; },
       dvec3(2.0)},
      {"cone", cone, mantle(cone), dvec3(2.5)},
      {"tube", tube, mantle(tube), dvec3(2.5)},
      {"box", box,
       [box](const dvec3& p) {
         const dvec3 position = glm::abs(glm::transpose(box.axes) * (p - box.center)) - box.half_size;
         return std::max(position.x, std::max(position.y, position.z));
       },
       dvec3(2.0)},
      {"convex solid", solid,
       [solid](const dvec3& p) {
         double most = -1e9;
         for (const HalfSpace& side : solid.sides)
           most = std::max(most, glm::dot(p, side.normal) - side.offset);
         return most;
       },
       dvec3(2.0)},
      {"ground", ground,
       [ground, nan](const dvec3& p) {
         if (std::fabs(p.x) > ground.half_size.x || std::fabs(p.y) > ground.half_size.y) return nan;
         return p.z - height_at(ground, {p.x, p.y}).height;
       },
       dvec3(30, 25, 1.5)},
  };
}

TEST(AnyShape, AnswersTheFirstRootOfItsImplicitEquation) {
  test::Random random;
  for (const Implicit& implicit : implicits()) {
    int hits = 0, misses = 0;
    for (int i = 0; i < 600; ++i) {
      dvec3 direction = glm::normalize(random.direction());
      if (i % 3 == 0) direction = glm::normalize(direction * dvec3(1, 1, 0.05));  // grazing
      const dvec3 origin = 2.0 * random.in_cube() * implicit.reach;
      if (i % 3 == 1) direction = 0.5 * random.in_cube() * implicit.reach - origin;  // towards the middle
      const Ray ray = make_ray(origin, direction, 0.0, 4.0 * glm::length(implicit.reach));
      const std::optional<double> t = intersect(implicit.shape, ray);
      ++(t ? hits : misses);
      if (t) {
        ASSERT_NEAR(implicit.value(ray.position(*t)), 0.0, 1e-9) << implicit.name << ' ' << i;
      }
      const double end = t ? *t : ray.t_max;
      constexpr int k_samples = 1500;
      double before = std::numeric_limits<double>::quiet_NaN();
      for (int k = 0; k < k_samples; ++k) {
        const double value = implicit.value(ray.position(end * (k + 0.5) / k_samples));
        ASSERT_FALSE(value * before < 0.0) << implicit.name << " ray " << i << " crosses before " << end;
        before = value;
      }
    }
    EXPECT_GT(hits, 60) << implicit.name;
    EXPECT_GT(misses, 60) << implicit.name;
  }
}

TEST(AnyShape, NormalIsTheGradientOfItsImplicitEquation) {
  test::Random random;
  for (const Implicit& implicit : implicits()) {
    int checked = 0;
    for (int i = 0; i < 500; ++i) {
      const dvec3 origin = 2.0 * random.in_cube() * implicit.reach;
      const Ray ray = make_ray(origin, 0.5 * random.in_cube() * implicit.reach - origin, 0.0, 1e3);
      const std::optional<double> t = intersect(implicit.shape, ray);
      if (!t) continue;
      const dvec3 position = ray.position(*t);
      dvec3 gradient;
      for (int axis = 0; axis < 3; ++axis) {
        dvec3 step(0.0);
        step[axis] = 1e-6;
        gradient[axis] = implicit.value(position + step) - implicit.value(position - step);
      }
      if (!(glm::length(gradient) > 1e-7)) continue;  // at an end of a mantle
      const dvec3 normal = surface_at(implicit.shape, position).normal;
      EXPECT_NEAR(glm::length(normal), 1.0, 1e-12);
      EXPECT_GT(glm::dot(normal, glm::normalize(gradient)), 1.0 - 1e-6) << implicit.name;
      ++checked;
    }
    EXPECT_GT(checked, 50) << implicit.name;
  }
}

TEST(AnyShape, BoundsEncloseEveryHit) {
  test::Random random;
  std::vector<Shape> shapes;
  for (const Implicit& implicit : implicits()) shapes.push_back(implicit.shape);
  shapes.push_back(Disc{{0.3, 0.1, 0.2}, glm::normalize(dvec3(1, 2, 3)), 1.4, 0.3});
  shapes.push_back(Niche{{{0.3, -0.2, 0.5}, some_axes(), {1.0, 0.6, 1.7}}});
  shapes.push_back(
      Panel{{-1, 0.3, -1}, some_axes()[0], some_axes()[1], {2.5, 2.0}, {{{0.5, 0.5}, {1, 1}, false}}});
  shapes.push_back(Polygon{{{-1, 0, -1}, {1.5, 0.5, -1}, {0.5, 0.2, 1.5}}});
  for (const Shape& shape : shapes) {
    Bounds bounds = bounds_of(shape);
    bounds.min -= 1e-9;
    bounds.max += 1e-9;
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
      const Ray ray = make_ray(3.0 * random.in_cube(), glm::normalize(random.direction()), 0.0, 100.0);
      const std::optional<double> t = intersect(shape, ray);
      if (!t) continue;
      ++hits;
      EXPECT_TRUE(bounds.contains(ray.position(*t))) << shape.index();
    }
    EXPECT_GT(hits, 20) << shape.index();
  }
}

}  // namespace
}  // namespace alidade::simulation::shapes
