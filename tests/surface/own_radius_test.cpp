// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/spacing.h"
#include "surface/brute_force_surface.h"
#include "surface/decide_point.h"
#include "surface/surface_cloud.h"
#include "tests/octree/ray_batches.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/support/ray_families.h"
#include "tests/support/same_hits.h"
#include "tests/support/spacings.h"
#include "tests/surface/surface_cases.h"

namespace alidade {
namespace {

using test::beside_lanes;
using test::Random;
using test::ray_cases;
using test::RayCase;
using test::same_hits;
using test::with_own_radii;

constexpr int k_neighbours = 3;
constexpr double k_factors[] = {0.01, 0.5, 1.0, 3.0, 1e6};

struct SpacedFamily {
  std::string name;
  PointCloud cloud;
  std::vector<double> spacings;  ///< by point id

  std::optional<Hit> closest(const Ray& ray, const SurfaceQuery& query) const {
    return brute_force::closest(cloud, ray, query, spacings);
  }
};

/// Made once: each spacing looks at every point.
const std::vector<SpacedFamily>& spaced_families() {
  static const std::vector<SpacedFamily> made = [] {
    std::vector<SpacedFamily> families;
    for (const test::PointFamily& family : test::point_families())
      families.push_back({family.name, family.cloud, brute_force::spacings(family.cloud, k_neighbours)});
    return families;
  }();
  return made;
}

SurfaceCloud spheres_of(const Octree& octree) {
  return SurfaceCloud::of_spheres(with_spacings(octree, k_neighbours));
}

class OwnRadiusVsBruteForce : public ::testing::TestWithParam<InstructionSet> {
 protected:
  Octree build_here(const PointCloud& cloud) { return build(cloud, {.instruction_set = GetParam()}); }
};

TEST_P(OwnRadiusVsBruteForce, closest_and_occluded_are_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const SpacedFamily& family : spaced_families()) {
    for (const test::NamedOctree& named : test::octrees_of(family.cloud, GetParam())) {
      const SurfaceCloud spheres = spheres_of(named.octree);
      Random random(family.name + "_own_radius");
      for (const RayCase& c : ray_cases(family.cloud, 25, random)) {
        const SurfaceQuery query = with_own_radii(c.query, k_factors[random.below(5)]);
        SCOPED_TRACE(family.name + " " + named.name + " factor " + std::to_string(query.spacing_factor));
        for (const Ray& ray : {c.ray, beside_lanes(c.ray)}) {
          const std::optional<Hit> expected = family.closest(ray, query);
          ASSERT_TRUE(same_hits(closest(spheres, ray, query), expected));
          ASSERT_EQ(occluded(spheres, ray, query), expected.has_value());
          ++(expected ? hit_count : miss_count);
        }
      }
    }
  }
  EXPECT_GT(hit_count, 600u);
  EXPECT_GT(miss_count, 600u);
}

/// How many of a batch's rays have a hit, all of them as by brute force.
std::size_t expect_as_brute_force(const SpacedFamily& family, const SurfaceCloud& spheres,
                                  const std::vector<Ray>& rays, const SurfaceQuery& query) {
  std::vector<std::optional<SurfaceHit>> hits(rays.size());
  std::vector<std::uint8_t> blocked(rays.size());
  closest(spheres, rays, query, hits);
  occluded(spheres, rays, query, blocked);
  std::size_t hit_count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::optional<Hit> expected = family.closest(rays[i], query);
    EXPECT_TRUE(same_hits(hits[i], expected)) << "ray " << i;
    EXPECT_TRUE(test::has_right_index(spheres, hits[i])) << "ray " << i;
    EXPECT_EQ(blocked[i] != 0, expected.has_value()) << "ray " << i;
    if (::testing::Test::HasFailure()) break;
    hit_count += expected.has_value();
  }
  return hit_count;
}

TEST_P(OwnRadiusVsBruteForce, batches_are_the_same_bits_on_every_family) {
  for (const SpacedFamily& family : spaced_families()) {
    const SurfaceCloud spheres = spheres_of(build_here(family.cloud));
    Random random(family.name + "_own_radius_batches");
    for (int turn = 0; turn < 8; ++turn) {
      SCOPED_TRACE(family.name + " turn " + std::to_string(turn));
      std::vector<RayCase> cases = ray_cases(family.cloud, 60, random);
      const SurfaceQuery query = with_own_radii(cases[0].query, k_factors[random.below(5)]);
      std::vector<Ray> rays;
      for (RayCase& c : cases) {
        if (turn % 4 >= 1) c.ray.origin = cases[0].ray.origin;
        if (turn % 4 >= 2) c.ray.direction = cases[0].ray.direction;
        if (turn % 4 == 2) c.ray.direction = unit_direction(c.ray.direction + 0.01 * random.in_cube());
        rays.push_back(c.ray);
      }
      expect_as_brute_force(family, spheres, rays, query);
      if (HasFailure()) return;
    }
  }
}

TEST_P(OwnRadiusVsBruteForce, rays_that_go_alike_have_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, ray_count = 0;
  for (const SpacedFamily& family : spaced_families()) {
    if (family.cloud.size() == 0) continue;
    const SurfaceCloud spheres = spheres_of(build_here(family.cloud));
    const double radius = std::min(automatic_radius(spheres.octree()), 1e12);
    Random random(family.name + "_alike_own_radius");
    for (int turn = 0; turn < 4; ++turn) {
      SCOPED_TRACE(family.name + " turn " + std::to_string(turn));
      const std::vector<Ray> rays = test::alike_rays(family.cloud, 150, random);
      SurfaceQuery query{.radius = radius * std::pow(10.0, random.between(-1.0, 1.0)),
                         .spacing_factor = random.between(0.3, 3.0),
                         .measure = turn >= 2 ? Measure::t : Measure::entry};
      if (turn % 2 == 1) query.entry_min = radius * random.between(-1.0, 1.0);
      hit_count += expect_as_brute_force(family, spheres, rays, query);
      ray_count += rays.size();
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(hit_count, 1000u);
  EXPECT_GT(ray_count - hit_count, 1000u);
}

TEST_P(OwnRadiusVsBruteForce, rays_at_a_site_far_from_other_points_have_the_same_bits) {
  const SpacedFamily& family =
      *std::ranges::find(spaced_families(), std::string("far_zeros"), &SpacedFamily::name);
  std::size_t hit_count = 0, ray_count = 0;
  for (const test::NamedOctree& named : test::octrees_of(family.cloud, GetParam())) {
    const SurfaceCloud spheres = spheres_of(named.octree);
    Random random(named.name);
    for (int turn = 0; turn < 4; ++turn) {
      SCOPED_TRACE(named.name + " turn " + std::to_string(turn));
      SurfaceQuery query{.radius = std::pow(10.0, random.between(-2.5, 0.5)),
                         .spacing_factor = random.between(0.3, 2.0),
                         .measure = turn % 2 ? Measure::t : Measure::entry};
      if (turn >= 2) query.entry_min = 0.0;
      const std::vector<Ray> rays = test::rays_at_site(family.cloud, 200, turn % 2 == 0, random);
      hit_count += expect_as_brute_force(family, spheres, rays, query);
      ray_count += rays.size();
      if (HasFailure()) return;
      for (std::size_t i = 0; i < rays.size(); i += 4) {
        const std::optional<Hit> expected = family.closest(rays[i], query);
        ASSERT_TRUE(same_hits(closest(spheres, rays[i], query), expected)) << i;
        ASSERT_EQ(occluded(spheres, rays[i], query), expected.has_value()) << i;
      }
    }
  }
  EXPECT_GT(hit_count, 1000u);
  EXPECT_GT(ray_count - hit_count, 500u);
}

TEST_P(OwnRadiusVsBruteForce, filters_hold_too) {
  for (const SpacedFamily& family : spaced_families()) {
    const double middle = family.cloud.size() > 0 ? family.cloud.bounds().center().x : 0.0;
    for (const test::NamedOctree& named : test::octrees_of(family.cloud, GetParam())) {
      SCOPED_TRACE(family.name + " " + named.name);
      const SurfaceCloud spheres = spheres_of(named.octree);
      Random random(family.name + "_own_radius_filters");
      const std::vector<RayCase> cases = ray_cases(family.cloud, 12, random);
      SurfaceQuery query = with_own_radii(cases[0].query, 1.0);
      query.filter.of_point = [](const Candidate& point) { return point.point_id % 3 != 0; };
      query.filter.of_position = [middle](const Candidate& point) { return point.position.x <= middle; };
      std::vector<Ray> rays;
      for (const RayCase& c : cases) rays.push_back(c.ray);
      expect_as_brute_force(family, spheres, rays, query);
      if (HasFailure()) return;
      for (const RayCase& c : cases) {
        for (const Ray& ray : {c.ray, beside_lanes(c.ray)}) {
          const std::optional<Hit> expected = family.closest(ray, query);
          ASSERT_TRUE(same_hits(closest(spheres, ray, query), expected));
          ASSERT_EQ(occluded(spheres, ray, query), expected.has_value());
        }
      }
    }
  }
}

/// What a filter sees of a point: its own radius, and no disc.
TEST_P(OwnRadiusVsBruteForce, filters_are_called_with_the_radius_of_the_point) {
  const SpacedFamily& family = spaced_families().back();
  const SurfaceCloud spheres = spheres_of(build_here(family.cloud));
  Random random("radius_in_filter");
  std::size_t calls = 0;
  for (const RayCase& c : ray_cases(family.cloud, 300, random)) {
    SurfaceQuery query = with_own_radii(c.query, 1.0);
    query.filter = [&](const Candidate& point) {
      ++calls;
      EXPECT_EQ(point.radius, own_radius(query, family.spacings[point.point_id]));
      EXPECT_LE(point.distance, point.radius);
      EXPECT_EQ(point.disc, nullptr);
      return point.point_id % 2 == 0;
    };
    (void)closest(spheres, c.ray, query);
    (void)occluded(spheres, c.ray, query);
    if (HasFailure()) return;
  }
  EXPECT_GT(calls, 100u);
}

/// Two walls, one scanned a hundred times as densely as the other, and rays that graze the points' spheres.
TEST_P(OwnRadiusVsBruteForce, spheres_of_very_different_radii_are_met_at_their_rims) {
  Random random("two_walls");
  std::vector<glm::dvec3> points;
  const glm::dvec3 site(690000.0, 5325000.0, 0.0);
  for (int i = 0; i < 3000; ++i)
    points.push_back(site + glm::dvec3(random.between(0.0, 0.1), 0.0, random.between(0.0, 0.1)));
  for (int i = 0; i < 300; ++i)
    points.push_back(site + glm::dvec3(random.between(0.0, 10.0), 5.0, random.between(0.0, 10.0)));
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-6), site});
  const std::vector<double> spacings = brute_force::spacings(cloud, 8);
  const SurfaceCloud spheres = SurfaceCloud::of_spheres(with_spacings(build_here(cloud), 8));
  for (const Measure measure : {Measure::entry, Measure::t}) {
    const SurfaceQuery query{.radius = 2.0, .spacing_factor = 0.5, .measure = measure};
    std::vector<Ray> rays;
    for (int i = 0; i < 800; ++i) {
      const auto id = static_cast<std::size_t>(random.below(points.size()));
      const glm::dvec3 along = unit_direction(random.in_cube());
      const glm::dvec3 across = unit_direction(glm::cross(along, random.in_cube()));
      const double rim =
          own_radius(query, spacings[id]) * (1.0 + std::pow(10.0, random.between(-16.0, -3.0)));
      rays.push_back(make_ray(cloud.world(id) + rim * across - 3.0 * along, along, 0.0));
    }
    std::vector<std::optional<SurfaceHit>> hits(rays.size());
    closest(spheres, rays, query, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      SCOPED_TRACE(i);
      const std::optional<Hit> expected = brute_force::closest(cloud, rays[i], query, spacings);
      ASSERT_TRUE(same_hits(hits[i], expected));
      ASSERT_TRUE(same_hits(closest(spheres, rays[i], query), expected));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, OwnRadiusVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

TEST(OwnRadius, a_hit_of_few_points_has_the_radius_known_on_paper) {
  const PointCloud cloud =
      test::make_cloud({{0, 0, 0}, {1, 0, 0}, {10, 0, 0}}, {glm::dvec3(0.5), glm::dvec3(0)});
  const Octree octree = with_spacings(build(cloud), 1);
  const SurfaceCloud spheres = SurfaceCloud::of_spheres(octree);
  const SurfaceQuery query{.radius = 4.0, .spacing_factor = 0.5};
  const auto radius_of = [&](const std::optional<SurfaceHit>& hit) {
    EXPECT_TRUE(hit);
    return hit ? own_radius(query, spacing_at(octree.layers(), hit->index)) : 0.0;
  };
  EXPECT_EQ(radius_of(closest(spheres, make_ray({0.0, -5.0, 0.25}, {0.0, 1.0, 0.0}), query)), 0.5);
  EXPECT_EQ(radius_of(closest(spheres, make_ray({10.0, -5.0, 1.0}, {0.0, 1.0, 0.0}), query)), 4.0);
}

}  // namespace
}  // namespace alidade
