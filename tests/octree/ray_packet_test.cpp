// SPDX-License-Identifier: MIT
// Batches of rays that go alike, which go through the tree in packets.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "tests/support/point_families.h"
#include "tests/support/ray_families.h"
#include "tests/support/same_hits.h"

namespace alidade {
namespace {

using test::Random;

/// Rays of nearly one direction: from one position (a camera), from anywhere, or from the points themselves
/// (to the sun), some of them with limits.
std::vector<Ray> alike_rays(const PointCloud& cloud, std::size_t count, Random& random) {
  std::vector<Ray> rays;
  const Bounds bounds = cloud.bounds();
  const double size = glm::length(bounds.size()) + 1e-3;
  const glm::dvec3 along = unit_direction(random.in_cube());
  const glm::dvec3 eye = bounds.center() - along * size * random.between(0.0, 2.0);
  const auto kind = random.below(3);
  const double spread = random.below(2) == 0 ? 0.0 : 0.01;
  for (std::size_t i = 0; i < count; ++i) {
    glm::dvec3 origin = eye;
    if (kind == 1) origin += 0.5 * size * random.in_cube();
    if (kind == 2) origin = cloud.world(static_cast<std::size_t>(random.below(cloud.size())));
    double t_min = kind == 0 ? -std::numeric_limits<double>::infinity() : 0.0;
    double t_max = std::numeric_limits<double>::infinity();
    if (random.below(4) == 0) t_min = size * random.between(-1.0, 1.0);
    if (random.below(4) == 0) t_max = size * random.between(-1.0, 3.0);
    // A few that do not go with the others, and some far away.
    const glm::dvec3 direction = random.below(50) == 0 ? random.in_cube() : along + spread * random.in_cube();
    if (random.below(60) == 0) origin -= 1e4 * size * along;
    rays.push_back(make_ray(origin, direction, t_min, t_max));
  }
  return rays;
}

class RayPacketVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(RayPacketVsBruteForce, rays_that_go_alike_have_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const test::PointFamily& family : test::point_families()) {
    if (family.cloud.size() == 0) continue;
    BuildOptions options;
    options.instruction_set = GetParam();
    const Octree octree = with_spacings(build(family.cloud, options), 3);
    const std::vector<double> spacings = brute_force::spacings(family.cloud, 3);
    const double radius = std::min(automatic_radius(octree), 1e12);
    Random random(family.name + "_alike");
    for (int turn = 0; turn < 10; ++turn) {
      const std::vector<Ray> rays = alike_rays(family.cloud, 150, random);
      RayQuery query{.radius = radius * std::pow(10.0, random.between(-1.0, 1.0)),
                     .measure = turn % 3 == 2 ? Measure::t : Measure::entry};
      if (turn % 2 == 1) query.entry_min = radius * random.between(-1.0, 1.0);
      if (turn % 5 == 4) query.spacing_factor = random.between(0.3, 3.0);
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(family.name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        const std::optional<Hit> expected = query.spacing_factor > 0.0
                                                ? brute_force::closest(family.cloud, rays[i], query, spacings)
                                                : brute_force::closest(family.cloud, rays[i], query);
        ASSERT_TRUE(test::same_hits(hits[i], expected));
        ASSERT_EQ(blocked[i] != 0, expected.has_value());
        ++(expected ? hit_count : miss_count);
      }
    }
  }
  EXPECT_GT(hit_count, 3000u);
  EXPECT_GT(miss_count, 3000u);
}

TEST_P(RayPacketVsBruteForce, limits_at_the_very_entry_of_a_sphere_hold) {
  // A wall, and rays that begin where they enter or leave spheres, or next to it.
  Random random("wall");
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 4000; ++i) points.emplace_back(random.between(0.0, 4.0), 0.0, random.between(0.0, 4.0));
  const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-6), glm::dvec3(0)});
  BuildOptions options;
  options.instruction_set = GetParam();
  const Octree octree = build(cloud, options);
  const glm::dvec3 along = unit_direction({0.2, 1.0, 0.1});
  for (const Measure measure : {Measure::entry, Measure::t}) {
    const RayQuery query{.radius = 0.15, .measure = measure, .entry_min = 0.0};
    std::vector<Ray> rays;
    for (int i = 0; i < 1500; ++i) {
      const glm::dvec3 from = glm::dvec3(random.between(0.0, 4.0), -1.0, random.between(0.0, 4.0));
      const std::optional<Hit> first = brute_force::closest(cloud, make_ray(from, along), {.radius = 0.15});
      if (!first) continue;
      const double beside = std::pow(10.0, random.between(-17.0, -3.0)) * (random.below(2) == 0 ? -1.0 : 1.0);
      rays.push_back(
          make_ray(from + (first->entry + beside) * along, along, random.below(2) == 0 ? 0.0 : -1.0));
    }
    std::vector<std::optional<Hit>> hits(rays.size());
    std::vector<std::uint8_t> blocked(rays.size());
    closest(octree, rays, query, hits);
    occluded(octree, rays, query, blocked);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      SCOPED_TRACE(i);
      const std::optional<Hit> expected = brute_force::closest(cloud, rays[i], query);
      ASSERT_TRUE(test::same_hits(hits[i], expected));
      ASSERT_EQ(blocked[i] != 0, expected.has_value());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, RayPacketVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

}  // namespace
}  // namespace alidade
