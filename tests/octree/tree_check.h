// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "octree/tree_walk.h"

namespace alidade::test {

/// Visits all nodes of an octree and checks what octree.h promises of every one.
class TreeCheck {
 public:
  TreeCheck(const TreeView& tree, const PointCloud& cloud, int leaf_size)
      : tree_(tree),
        cloud_(cloud),
        leaf_size_(leaf_size),
        seen_(cloud.size()),
        visited_(tree.node_count),
        index_(cloud.size()) {}

  void run() {
    ASSERT_EQ(tree_.point_count, cloud_.size());
    if (cloud_.size() == 0) {
      EXPECT_EQ(tree_.node_count, 0u);
      EXPECT_EQ(tree_.level_count, 0);
      return;
    }
    visit(root_frame(tree_));
    EXPECT_EQ(seen_, std::vector<int>(cloud_.size(), 1)) << "every id once";
    EXPECT_EQ(visited_, std::vector<int>(tree_.node_count, 1)) << "every node once";
    EXPECT_EQ(tree_.level_count, deepest_ + 1);
    EXPECT_LE(tree_.level_count, k_max_tree_depth);
    EXPECT_EQ(exact_count_, tree_.exact_count());
  }

 private:
  /// Ids of the points of a subtree: those of its leaves, then those of its children in slot order.
  using Ids = std::vector<std::uint32_t>;

  Ids visit(const Frame& frame) {
    deepest_ = std::max(deepest_, frame.depth);
    EXPECT_GE(frame.level, k_min_frame_level);
    if (frame.node >= tree_.node_count || frame.depth >= k_max_tree_depth) {
      ADD_FAILURE() << "node out of range";
      return {};
    }
    ++visited_[frame.node];
    const Node& node = tree_.nodes[frame.node];
    std::array<Ids, k_node_width> below;
    for (int slot = 0; slot < k_node_width; ++slot) {
      const std::uint8_t kind = node.kind[slot];
      if (kind == 0) continue;
      if (is_inner(kind)) {
        const Frame child = child_frame(tree_, frame, slot);
        EXPECT_GT(child.node, frame.node) << "children follow their parents";
        below[slot] = visit(child);
      } else {
        below[slot] = ids_of(frame, child_leaf(tree_, frame, slot));
      }
      check_box(frame, slot, below[slot]);
    }
    if (frame.level == k_min_frame_level) check_equal_boxes(node, below);
    Ids all;
    for (const bool is_inner_turn : {false, true}) {
      for (int slot = 0; slot < k_node_width; ++slot)
        if (is_inner(node.kind[slot]) == is_inner_turn)
          all.insert(all.end(), below[slot].begin(), below[slot].end());
    }
    EXPECT_FALSE(all.empty());
    if (frame.level <= k_exact_frame_level) {
      for (std::size_t i = 0; i < all.size(); ++i)
        EXPECT_EQ(index_[all[i]], index_[all[0]] + i) << "points of a subtree are stored one after another";
    }
    return all;
  }

  Ids ids_of(const Frame& frame, const Leaf& leaf) {
    EXPECT_LE(leaf.count, static_cast<std::uint32_t>(leaf_size_));
    EXPECT_EQ(leaf.depth, frame.depth);
    EXPECT_LE(std::uint64_t{leaf.first} + leaf.count, tree_.point_count);
    const bool is_exact = tree_.positions && leaf.first >= tree_.first_exact;
    EXPECT_EQ(is_exact, frame.level > k_exact_frame_level);
    exact_count_ += is_exact ? leaf.count : 0;
    Ids ids;
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const auto id = static_cast<std::uint32_t>(point_id(tree_, leaf.first + i));
      EXPECT_LT(id, cloud_.size());
      ++seen_[id];
      index_[id] = leaf.first + i;
      EXPECT_EQ(position_of(tree_, leaf, i), cloud_.positions[id]) << "without loss";
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(tree_.coordinates[3 * leaf.first + axis * leaf.count + i],
                  (steps(id, axis) - frame.corner[axis]) >> coordinate_shift(frame.level));
      }
      ids.push_back(id);
    }
    return ids;
  }

  /// The box of a slot is the smallest on the frame's grid around the points below.
  void check_box(const Frame& frame, int slot, const Ids& ids) {
    const Node& node = tree_.nodes[frame.node];
    const Bounds bounds = child_bounds(tree_, frame, slot);
    for (int axis = 0; axis < 3; ++axis) {
      std::uint32_t low = 0xffffffffu, high = 0;
      for (const std::uint32_t id : ids) {
        low = std::min(low, (steps(id, axis) - frame.corner[axis]) >> (frame.level - k_min_frame_level));
        high = std::max(high, (steps(id, axis) - frame.corner[axis]) >> (frame.level - k_min_frame_level));
      }
      EXPECT_EQ(node.low[axis][slot], low);
      EXPECT_EQ(node.high[axis][slot], high);
    }
    for (const std::uint32_t id : ids) EXPECT_TRUE(bounds.contains(cloud_.world(id)));
  }

  /// At the lowest level, slots with equal boxes hold points of one position, the lowest ids first.
  void check_equal_boxes(const Node& node, const std::array<Ids, k_node_width>& below) {
    std::map<std::array<std::uint8_t, 6>, Ids> first_with_box;
    for (int slot = 0; slot < k_node_width; ++slot) {
      if (below[slot].empty()) continue;
      std::array<std::uint8_t, 6> box;
      for (int axis = 0; axis < 3; ++axis) {
        box[axis] = node.low[axis][slot];
        box[3 + axis] = node.high[axis][slot];
      }
      const auto [first, is_new] = first_with_box.emplace(box, below[slot]);
      if (is_new) continue;
      const LatticePosition position = cloud_.positions[first->second[0]];
      for (const std::uint32_t id : first->second) EXPECT_EQ(cloud_.positions[id], position);
      for (const std::uint32_t id : below[slot]) EXPECT_EQ(cloud_.positions[id], position);
      EXPECT_LT(std::ranges::max(first->second), std::ranges::min(below[slot]));
    }
  }

  std::uint32_t steps(std::uint32_t id, int axis) const {
    return static_cast<std::uint32_t>(cloud_.positions[id][axis]) -
           static_cast<std::uint32_t>(tree_.base[axis]);
  }

  const TreeView& tree_;
  const PointCloud& cloud_;
  const int leaf_size_;
  std::vector<int> seen_, visited_;
  std::vector<std::uint32_t> index_;  ///< storage index by id
  int deepest_ = 0;
  std::uint32_t exact_count_ = 0;
};

}  // namespace alidade::test
