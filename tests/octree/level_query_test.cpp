// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tests/octree/as_brute_force.h"
#include "tests/support/positions.h"

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
        return levels[point.point_id] <= max_level && c.query.filter.admits(point);
      };
      const auto expected = brute_force::find(family.cloud, c.target, filtered);
      const Octree octree_of_set = octree.with_instruction_set(sets[turn++ % sets.size()]);
      ASSERT_TRUE(same_hits(find(octree_of_set, c.target, coarse), expected));
      ASSERT_EQ(count(octree_of_set, c.target, coarse), expected.size());
      if constexpr (requires { closest(octree_of_set, c.target, coarse); }) {
        ASSERT_EQ(occluded(octree_of_set, c.target, coarse), !expected.empty());
        const auto first = closest(octree_of_set, c.target, coarse);
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

TEST(MaxLevel, gives_the_coarse_levels_of_a_layered_octree_to_batches_of_rays) {
  const PointFamily family = point_families().back();
  const Octree octree = build(family.cloud, {.organisation = Organisation::layered, .leaf_size = 4});
  Random random("levels of batches");
  const Positions positions(family.cloud, random);
  const glm::dvec3 along = random.direction();
  const auto number_of = [](std::span<const std::uint8_t> answers) {
    return static_cast<std::size_t>(std::ranges::count(answers, std::uint8_t{1}));
  };
  // Through the tree in packets, or together one node after another: they start side by side.
  constexpr int k_rays = 3000;
  for (const bool go_alike : {true, false}) {
    std::vector<Ray> rays;
    for (int i = 0; i < k_rays; ++i) {
      const glm::dvec3 origin = positions.bounds().min + positions.bounds().size() * (double(i) / k_rays);
      rays.push_back(make_ray(origin, go_alike ? along + 0.001 * random.in_cube() : random.direction()));
    }
    std::vector<std::size_t> blocked_by_level;
    for (int level = 0; level < octree.view().level_count; ++level) {
      const RayQuery query{.radius = 0.2 * positions.spacing(), .max_level = level};
      for (const InstructionSet set : available_instruction_sets()) {
        SCOPED_TRACE("level " + std::to_string(level) + ", " + std::string(name(set)));
        const Octree octree_of_set = octree.with_instruction_set(set);
        std::vector<std::optional<Hit>> hits(rays.size());
        std::vector<std::uint8_t> blocked(rays.size());
        closest(octree_of_set, rays, query, hits);
        occluded(octree_of_set, rays, query, blocked);
        for (std::size_t i = 0; i < rays.size(); ++i) {
          ASSERT_TRUE(same_hits(hits[i], closest(octree_of_set, rays[i], query))) << i;
          ASSERT_EQ(blocked[i] != 0, hits[i].has_value()) << i;
        }
        if (set == InstructionSet::scalar) blocked_by_level.push_back(number_of(blocked));
      }
    }
    EXPECT_LT(blocked_by_level[0], blocked_by_level[1]);
    EXPECT_LT(blocked_by_level[1], blocked_by_level.back());
  }
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
