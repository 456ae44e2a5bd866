// SPDX-License-Identifier: MIT
#include "tests/octree/as_brute_force.h"

namespace alidade {
namespace {

using namespace test;

/// Asks the first levels of layered octrees, and brute force with a filter on the level of a point.
template <class MakeCases>
void expect_first_levels(const MakeCases& make_cases) {
  const std::vector<InstructionSet> sets = available_instruction_sets();
  std::size_t thinned = 0, turn = 0;
  for (const PointFamily& family : point_families()) {
    const Octree octree = build(family.cloud, {.organisation = Organisation::layered, .leaf_size = 4});
    const std::vector<int> levels = levels_by_id(octree);
    const std::string seed = "levels of " + family.name;
    Random random(seed);
    for (const auto& c : make_cases(family.cloud, 25, random)) {
      const auto level_count = static_cast<std::uint64_t>(octree.view().level_count);
      const int max_level = static_cast<int>(random.below(level_count + 2));
      SCOPED_TRACE("seed \"" + seed + "\" up to level " + std::to_string(max_level) + ": " + describe(c));
      auto coarse = c.query, filtered = c.query;
      coarse.max_level = max_level;
      filtered.filter = [&](const Candidate& point) {
        return levels[point.point_id] <= max_level && (!c.query.filter || c.query.filter(point));
      };
      const auto expected = brute_force::find(family.cloud, c.target, filtered);
      const Octree asked = octree.with_instruction_set(sets[turn++ % sets.size()]);
      ASSERT_TRUE(same_hits(find(asked, c.target, coarse), expected));
      ASSERT_EQ(count(asked, c.target, coarse), expected.size());
      if constexpr (requires { closest(asked, c.target, coarse); }) {
        ASSERT_EQ(occluded(asked, c.target, coarse), !expected.empty());
        const auto first = closest(asked, c.target, coarse);
        ASSERT_TRUE(same_hits(first, brute_force::closest(family.cloud, c.target, filtered)));
      }
      thinned += expected.size() < count(octree, c.target, c.query);
    }
  }
  EXPECT_GT(thinned, 40u);
}

TEST(MaxLevel, gives_the_coarse_levels_of_a_layered_octree_to_rays) {
  expect_first_levels(find_ray_cases);
}

TEST(MaxLevel, gives_the_coarse_levels_of_a_layered_octree_to_cones) {
  expect_first_levels(cone_cases);
}

TEST(MaxLevel, gives_the_coarse_levels_of_a_layered_octree_to_paths) {
  expect_first_levels(path_cases);
}

TEST(MaxLevel, gives_the_coarse_levels_of_a_layered_octree_to_half_spaces) {
  expect_first_levels(region_cases);
}

TEST(MaxLevel, gives_the_coarse_levels_of_a_layered_octree_to_boxes) {
  expect_first_levels(box_cases);
}

TEST(MaxLevel, gives_the_coarse_levels_of_a_layered_octree_to_points) {
  expect_first_levels(point_cases);
}

TEST(MaxLevel, beyond_the_last_level_is_the_whole_cloud) {
  const PointFamily family = point_families().back();
  const Octree octree = build(family.cloud, {.organisation = Organisation::layered});
  const HalfSpaces everywhere;
  EXPECT_EQ(count(octree, everywhere, {.max_level = octree.view().level_count - 1}), octree.size());
  EXPECT_EQ(count(octree, everywhere, {.max_level = 1000000}), octree.size());
  EXPECT_LT(count(octree, everywhere, {.max_level = 1}), octree.size());
}

}  // namespace
}  // namespace alidade
