// SPDX-License-Identifier: MIT
// Trees of a site and a few points far away, such as invalid ones at 0 0 0.
#include <gtest/gtest.h>

#include <cmath>

#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/query.h"
#include "tests/octree/ray_batches.h"
#include "tests/support/octrees.h"
#include "tests/support/random.h"
#include "tests/support/same_hits.h"

namespace alidade {
namespace {

using test::Random;

bool has_site(const TreeView& tree) {
  return tree.extent.site_level < tree.root_level;
}

TEST(Site, holds_all_but_the_points_far_away) {
  const PointCloud cloud = test::family_named("far_zeros");
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
    const Octree octree = build(test::family_named(name));
    EXPECT_FALSE(has_site(octree.view())) << name;
    EXPECT_EQ(octree.view().extent.site_width, octree.view().extent.frame_width) << name;
  }
}

class SiteVsBruteForce : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(SiteVsBruteForce, rays_have_the_same_bits) {
  const PointCloud cloud = test::family_named("far_zeros");
  std::size_t hit_count = 0, miss_count = 0;
  for (const auto& [name, octree] : test::octrees_of(cloud, GetParam())) {
    Random random(name);
    for (int turn = 0; turn < 8; ++turn) {
      RayQuery query{.radius = std::pow(10.0, random.between(-2.5, 0.5)),
                     .measure = turn % 2 ? Measure::t : Measure::entry};
      if (turn % 4 == 1) query.entry_min = 0.0;
      const std::vector<Ray> rays = test::rays_at_site(cloud, 200, turn % 2 == 0, random);
      std::vector<std::optional<Hit>> hits(rays.size());
      std::vector<std::uint8_t> blocked(rays.size());
      closest(octree, rays, query, hits);
      occluded(octree, rays, query, blocked);
      for (std::size_t i = 0; i < rays.size(); ++i) {
        SCOPED_TRACE(name + " turn " + std::to_string(turn) + " ray " + std::to_string(i));
        const std::optional<Hit> expected = brute_force::closest(cloud, rays[i], query);
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
