// SPDX-License-Identifier: MIT
// Trees of a site and a few points far away, such as invalid ones at 0 0 0.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/query.h"
#include "octree/spacing.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/same_hits.h"

namespace alidade {
namespace {

using test::Random;

PointCloud family_named(const std::string& name) {
  for (const test::PointFamily& family : test::point_families())
    if (family.name == name) return family.cloud;
  throw std::runtime_error("no family " + name);
}

bool has_site(const TreeView& tree) {
  return tree.extent.site_level < tree.root_level;
}

TEST(Site, holds_all_but_the_points_far_away) {
  const PointCloud cloud = family_named("far_zeros");
  for (const auto& [name, octree] : test::octrees_of(cloud)) {
    SCOPED_TRACE(name);
    const TreeView& tree = octree.view();
    if (!has_site(tree)) continue;
    EXPECT_LT(tree.extent.site_width, 1000.0);
    std::size_t outside = 0;
    for (const LatticePosition& position : cloud.positions) {
      for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t steps =
            std::int64_t{position[axis]} - tree.base[axis] - tree.extent.site_corner[axis];
        if (steps >= 0 && steps >> tree.extent.site_level == 0) continue;
        ++outside;
        break;
      }
    }
    EXPECT_GE(outside, cloud.size() / 2);
    EXPECT_LT(outside, cloud.size() * 5 / 8);
  }
  EXPECT_TRUE(has_site(build(cloud).view()));
}

TEST(Site, is_the_whole_tree_where_most_of_it_is_in_use) {
  for (const char* name :
       {"no_point", "one_point", "all_equal", "street", "two_far_clusters", "whole_lattice"}) {
    const Octree octree = build(family_named(name));
    EXPECT_FALSE(has_site(octree.view())) << name;
    EXPECT_EQ(octree.view().extent.site_width, octree.view().extent.frame_width) << name;
  }
}

/// From near the site's points, a few of them from the zeros and towards them.
std::vector<Ray> rays_at(const PointCloud& cloud, std::size_t count, bool are_alike, Random& random) {
  const auto site_point = [&] {
    return cloud.world(2 * static_cast<std::size_t>(random.below(cloud.size() / 2)));
  };
  const glm::dvec3 along = unit_direction(random.in_cube());
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const glm::dvec3 target = site_point();
    glm::dvec3 origin = site_point(), direction = target - origin;
    if (are_alike) {
      direction = along + 0.01 * random.in_cube();
      if (random.below(2) == 0) origin = target - std::pow(10.0, random.between(-2.0, 3.5)) * direction;
    }
    if (random.below(3) == 0) origin += 0.1 * random.in_cube();
    if (random.below(20) == 0) origin = glm::dvec3(0.0), direction = target;
    if (random.below(20) == 0) direction = -origin;
    if (random.below(30) == 0) direction = {0.0, random.below(2) ? 0.0 : -0.0, -1.0};
    if (direction == glm::dvec3(0.0)) continue;
    const double t_min =
        random.below(3) == 0 ? -std::numeric_limits<double>::infinity() : random.between(0.0, 0.1);
    rays.push_back(make_ray(origin, direction, t_min, random.below(3) == 0 ? 100.0 : 1e9));
  }
  return rays;
}

class SiteVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(SiteVsBruteForce, rays_have_the_same_bits) {
  const PointCloud cloud = family_named("far_zeros");
  const std::vector<double> spacings = brute_force::spacings(cloud, 3);
  std::size_t hit_count = 0, miss_count = 0;
  for (const auto& [name, plain] : test::octrees_of(cloud, GetParam())) {
    const Octree octree = with_spacings(plain, 3);
    Random random(name);
    for (int turn = 0; turn < 8; ++turn) {
      RayQuery query{.radius = std::pow(10.0, random.between(-2.5, 0.5)),
                     .measure = turn % 2 ? Measure::t : Measure::entry};
      if (turn % 4 == 1) query.entry_min = 0.0;
      if (turn % 4 >= 2) query.spacing_factor = random.between(0.3, 2.0);
      const std::vector<Ray> rays = rays_at(cloud, 200, turn % 2 == 0, random);
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        const std::optional<Hit> expected = query.spacing_factor > 0.0
                                                ? brute_force::closest(cloud, rays[i], query, spacings)
                                                : brute_force::closest(cloud, rays[i], query);
        ASSERT_TRUE(test::same_hits(hits[i], expected));
        ASSERT_EQ(blocked[i] != 0, expected.has_value());
        if (i % 4 == 0) {
          ASSERT_TRUE(test::same_hits(closest(octree, rays[i], query), expected));
          ASSERT_EQ(occluded(octree, rays[i], query), expected.has_value());
        }
        ++(expected ? hit_count : miss_count);
      }
    }
  }
  EXPECT_GT(hit_count, 2000u);
  EXPECT_GT(miss_count, 1000u);
}

INSTANTIATE_TEST_SUITE_P(, SiteVsBruteForce, ::testing::ValuesIn(available_instruction_sets()),
                         [](const auto& set) { return std::string(name(set.param)); });

}  // namespace
}  // namespace alidade
