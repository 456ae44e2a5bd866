// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "octree/building/child_ranges.h"
#include "octree/building/leaf_writer.h"

namespace alidade {

/// A node in the making: its children are chosen, their boxes need not be known yet.
struct NodeDraft {
  Steps corner{};
  int level = 0;  ///< of the frame
  ChildList children;
  std::array<StepBox, k_node_width> boxes;
  std::uint32_t first_child = 0, first_point = 0;

  StepBox box() const {
    StepBox all;
    for (const StepBox& child : boxes) all.grow(child);
    return all;
  }

  /// Points of the leaves among its children.
  std::uint32_t leaf_point_count() const {
    std::uint32_t count = 0;
    for (const ChildRange& child : children) count += child.is_leaf ? child.points.count() : 0;
    return count;
  }

  /// Children that are nodes.
  std::size_t inner_count() const {
    return static_cast<std::size_t>(
        std::count_if(children.begin(), children.end(), [](const ChildRange& c) { return !c.is_leaf; }));
  }

  /// The node. Requires that all boxes are known; `rules`: those the children were chosen by.
  Node node(const SplitRules& rules) const {
    Node node{};
    node.first_child = first_child;
    node.first_point = first_point;
    for (int slot = 0; slot < children.count; ++slot) {
      const auto grid_step = [&](std::uint32_t step, int axis) {
        return static_cast<std::uint8_t>((step - corner[axis]) >> (level - k_min_frame_level));
      };
      for (int axis = 0; axis < 3; ++axis) {
        node.low[axis][slot] = grid_step(boxes[slot].low[axis], axis);
        node.high[axis][slot] = grid_step(boxes[slot].high[axis], axis);
      }
      const ChildRange& child = children[slot];
      node.kind[slot] = static_cast<std::uint8_t>(
          child.is_leaf ? child.points.count()
                        : k_inner_kind + level - rules.child_frame_level(child.points, level));
    }
    return node;
  }
};

}  // namespace alidade
