// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "octree/brute_force.h"
#include "octree/build.h"
#include "octree/query.h"
#include "tests/octree/tree_check.h"
#include "tests/support/point_families.h"
#include "tests/support/ray_families.h"

namespace alidade {
namespace {

using test::PointFamily;

const Lattice k_millimetre{glm::dvec3(0.001), glm::dvec3(0.0)};

Octree build_as(Organisation organisation, const PointCloud& cloud, double cell_size = 0.0) {
  BuildOptions options;
  options.organisation = organisation;
  options.cell_size = cell_size;
  return build(cloud, options);
}

PointCloud random_surface(std::size_t count) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (std::size_t i = 0; i < count; ++i)
    positions.push_back({random.between(0, 40), random.between(0, 40), random.between(0, 0.02)});
  return test::make_cloud(positions, k_millimetre);
}

/// Cell of a grid of 2^level lattice steps from the tree's base.
std::array<std::uint32_t, 3> cell_of(const TreeView& tree, const LatticePosition& position, int level) {
  std::array<std::uint32_t, 3> cell;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint32_t steps =
        static_cast<std::uint32_t>(position[axis]) - static_cast<std::uint32_t>(tree.base[axis]);
    cell[axis] = level >= 32 ? 0 : steps >> level;
  }
  return cell;
}

TEST(FixedOctree, every_leaf_lies_in_one_cell_of_the_size_asked_for) {
  for (const PointFamily& family : test::point_families()) {
    for (const int level : {0, 3, 9, 14, 18, 25}) {
      SCOPED_TRACE(family.name + " level " + std::to_string(level));
      const glm::dvec3& scale = family.cloud.lattice.scale;
      const double side = std::max({scale.x, scale.y, scale.z}) * std::ldexp(1.0, level);
      // A little longer than such a cell and much shorter than the next.
      const Octree octree = build_as(Organisation::fixed, family.cloud, side * 1.01);
      const TreeView& tree = octree.view();
      test::TreeCheck(tree, family.cloud, k_max_leaf_size).run();
      // Every cell has as few leaves as its number of points allows for parts of an eighth.
      std::map<std::array<std::uint32_t, 3>, std::pair<std::size_t, std::size_t>> points_and_leaves;
      for_each_leaf(tree, [&](const Leaf& leaf) {
        std::set<std::array<std::uint32_t, 3>> cells;
        for (std::uint32_t i = 0; i < leaf.count; ++i)
          cells.insert(cell_of(tree, position_of(tree, leaf, i), level));
        ASSERT_EQ(cells.size(), 1u);
        auto& [points, leaves] = points_and_leaves[*cells.begin()];
        points += leaf.count;
        ++leaves;
      });
      for (const auto& [cell, count] : points_and_leaves) {
        const auto& [points, leaves] = count;
        if (points <= k_max_leaf_size) {
          ASSERT_EQ(leaves, 1u);
        } else {
          ASSERT_LE(leaves, 8 * points / k_max_leaf_size);
        }
      }
    }
  }
}

TEST(FixedOctree, without_a_size_cells_are_the_largest_that_fill_a_leaf_on_average) {
  const PointCloud cloud = random_surface(20000);
  const Octree octree = build_as(Organisation::fixed, cloud);
  const TreeView& tree = octree.view();
  const auto points_per_cell = [&](int level) {
    std::set<std::array<std::uint32_t, 3>> cells;
    for (const LatticePosition& position : cloud.positions) cells.insert(cell_of(tree, position, level));
    return static_cast<double>(cloud.size()) / static_cast<double>(cells.size());
  };
  int level = 0;
  while (points_per_cell(level + 1) <= k_max_leaf_size) ++level;
  for_each_leaf(tree, [&](const Leaf& leaf) {
    for (std::uint32_t i = 1; i < leaf.count; ++i)
      ASSERT_EQ(cell_of(tree, position_of(tree, leaf, i), level),
                cell_of(tree, position_of(tree, leaf, 0), level));
  });
  std::size_t leaf_count = 0;
  for_each_leaf(tree, [&](const Leaf&) { ++leaf_count; });
  EXPECT_GT(static_cast<double>(cloud.size()) / static_cast<double>(leaf_count),
            0.4 * points_per_cell(level));
}

TEST(LayeredOctree, every_node_above_others_holds_a_full_sample_of_its_own) {
  for (const PointFamily& family : test::point_families()) {
    SCOPED_TRACE(family.name);
    const Octree octree = build_as(Organisation::layered, family.cloud);
    const TreeView& tree = octree.view();
    if (octree.size() == 0) continue;
    std::vector<Frame> stack{root_frame(tree)};
    while (!stack.empty()) {
      const Frame frame = stack.back();
      stack.pop_back();
      int leaves = 0, points = 0, inner = 0;
      for (int slot = 0; slot < k_node_width; ++slot) {
        const std::uint8_t kind = tree.nodes[frame.node].kind[slot];
        leaves += is_leaf(kind);
        points += is_leaf(kind) ? kind : 0;
        if (!is_inner(kind)) continue;
        ++inner;
        stack.push_back(child_frame(tree, frame, slot));
      }
      if (inner == 0 || frame.level == k_min_frame_level)
        continue;  // the lowest level is for points of one position
      // A node may only reach down to a smaller frame, for points of one position or few points of a small
      // cell.
      if (leaves == 0) {
        EXPECT_EQ(inner, 1);
      } else {
        EXPECT_EQ(leaves, 1);
        EXPECT_EQ(points, k_max_leaf_size);
        EXPECT_TRUE(is_leaf(tree.nodes[frame.node].kind[0]));
      }
    }
  }
}

TEST(LayeredOctree, coarse_levels_are_a_thinned_cloud) {
  const PointCloud cloud = random_surface(60000);
  const Octree octree = build_as(Organisation::layered, cloud);
  const TreeView& tree = octree.view();
  ASSERT_GE(tree.level_count, 4);
  // Of a grid of squares over the surface, how many have a point of the first levels?
  const auto covered_share = [&](int max_level, int squares) {
    std::set<std::pair<int, int>> covered;
    for_each_leaf(tree, [&](const Leaf& leaf) {
      if (leaf.depth > max_level) return;
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const LatticePosition position = position_of(tree, leaf, i);
        covered.emplace(position.x * squares / 40001, position.y * squares / 40001);
      }
    });
    return static_cast<double>(covered.size()) / (squares * squares);
  };
  EXPECT_GT(covered_share(0, 4), 0.9);
  EXPECT_GT(covered_share(1, 8), 0.9);
  EXPECT_GT(covered_share(2, 16), 0.9);
  std::vector<std::size_t> points_at(static_cast<std::size_t>(tree.level_count));
  for_each_leaf(tree,
                [&](const Leaf& leaf) { points_at[static_cast<std::size_t>(leaf.depth)] += leaf.count; });
  EXPECT_EQ(points_at[0], 32u);
  for (int level : {1, 2}) {
    EXPECT_GE(points_at[level], 3 * points_at[level - 1]);
    EXPECT_LE(points_at[level], 7 * points_at[level - 1]);
  }
}

TEST(Organisation, answers_are_those_of_brute_force_where_many_points_share_few_positions) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 3000; ++i) {
    // Two millimetres wide: every node is at the lowest level or just above it.
    positions.push_back(0.001 * glm::dvec3(random.below(3), random.below(2), random.below(3)));
  }
  const PointCloud cloud = test::make_cloud(positions, k_millimetre);
  const std::vector<test::RayCase> cases = test::ray_cases(cloud, 300, random);
  for (const Organisation organisation :
       {Organisation::adaptive, Organisation::fixed, Organisation::layered}) {
    for (const double cell_size : {0.0, 0.002, 0.1}) {
      const Octree octree = build_as(organisation, cloud, cell_size);
      test::TreeCheck(octree.view(), cloud, k_max_leaf_size).run();
      for (const test::RayCase& c : cases) {
        ASSERT_EQ(closest(octree, c.ray, c.query), brute_force::closest(cloud, c.ray, c.query))
            << static_cast<int>(organisation);
      }
    }
  }
}

}  // namespace
}  // namespace alidade
