// SPDX-License-Identifier: MIT
// Batches of rays that go alike, which go through the tree in packets.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "tests/octree/ray_batches.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"
#include "tests/support/same_hits.h"

namespace alidade {
namespace {

using test::Random;

class RayPacketVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(RayPacketVsBruteForce, rays_that_go_alike_have_the_same_bits_on_every_family) {
  std::size_t hit_count = 0, miss_count = 0;
  for (const test::PointFamily& family : test::point_families()) {
    if (family.cloud.size() == 0) continue;
    BuildOptions options;
    options.instruction_set = GetParam();
    const Octree octree = build(family.cloud, options);
    const double radius = std::min(automatic_radius(octree), 1e12);
    Random random(family.name + "_alike");
    for (int turn = 0; turn < 10; ++turn) {
      const std::vector<Ray> rays = test::alike_rays(family.cloud, 150, random);
      RayQuery query{.radius = radius * std::pow(10.0, random.between(-1.0, 1.0)),
                     .measure = turn % 3 == 2 ? Measure::t : Measure::entry};
      if (turn % 2 == 1) query.entry_min = radius * random.between(-1.0, 1.0);
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(family.name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        const std::optional<Hit> expected = brute_force::closest(family.cloud, rays[i], query);
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
  // Walls, and rays that begin where they enter or leave spheres, or next to it: so many, for one thread, that
  // they go in packets. On the second wall few spheres overlap, so that the answer hangs on one.
  tbb::task_arena one_thread(1);
  Random random("wall");
  for (const int count : {4000, 60}) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i < count; ++i)
      points.emplace_back(random.between(0.0, 4.0), 0.0, random.between(0.0, 4.0));
    const PointCloud cloud = test::make_cloud(points, {glm::dvec3(1e-6), glm::dvec3(0)});
    BuildOptions options;
    options.instruction_set = GetParam();
    const Octree octree = build(cloud, options);
    const glm::dvec3 along = unit_direction({0.2, 1.0, 0.1});
    for (const Measure measure : {Measure::entry, Measure::t}) {
      const RayQuery query{.radius = 0.15, .measure = measure, .entry_min = 0.0};
      std::vector<Ray> rays;
      while (rays.size() < 2400) {
        const glm::dvec3 from = glm::dvec3(random.between(0.0, 4.0), -1.0, random.between(0.0, 4.0));
        const std::optional<Hit> first = brute_force::closest(cloud, make_ray(from, along), {.radius = 0.15});
        if (!first) continue;
        const double beside =
            std::pow(10.0, random.between(-17.0, -3.0)) * (random.below(2) == 0 ? -1.0 : 1.0);
        const double at = random.below(2) == 0 ? first->entry : first->t;
        const double t_min = random.below(2) == 0 ? 0.0 : -1.0;
        const double t_max = random.below(2) == 0 ? std::numeric_limits<double>::infinity() : first->t - at;
        rays.push_back(make_ray(from + (at + beside) * along, along, t_min, t_max));
      }
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      one_thread.execute([&] {
        closest(octree, rays, query, hits);
        occluded(octree, rays, query, blocked);
      });
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(i);
        const std::optional<Hit> expected = brute_force::closest(cloud, rays[i], query);
        ASSERT_TRUE(test::same_hits(hits[i], expected));
        ASSERT_EQ(blocked[i] != 0, expected.has_value());
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, RayPacketVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

}  // namespace
}  // namespace alidade
