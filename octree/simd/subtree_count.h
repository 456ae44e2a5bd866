// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>

#include "octree/tree_walk.h"

// How many points stand below a node, without visiting them: from frames of level k_exact_frame_level on, all
// points below a node stand one after another, first those of its leaves, then those of its inner children in
// slot order.

namespace alidade::simd {

/// Past the last place below a node whose frame's level is at most k_exact_frame_level.
inline std::uint32_t end_place(const TreeView& tree, std::uint32_t index) {
  for (;;) {
    const Node& node = tree.nodes[index];
    std::uint32_t points = node.first_point, inner = 0;
    for (const std::uint8_t kind : node.kind) {
      if (is_inner(kind)) {
        ++inner;
      } else {
        points += kind;
      }
    }
    if (inner == 0) return points;
    index = node.first_child + inner - 1;
  }
}

/// Points of a child and all below it.
inline std::uint32_t subtree_count(const TreeView& tree, const Frame& parent, int slot) {
  const Node& node = tree.nodes[parent.node];
  if (is_leaf(node.kind[slot])) return node.kind[slot];
  const Frame child = child_frame(tree, parent, slot);
  if (child.level <= k_exact_frame_level)
    return end_place(tree, child.node) - tree.nodes[child.node].first_point;
  std::uint32_t count = 0;
  for (int below = 0; below < k_node_width; ++below)
    if (tree.nodes[child.node].kind[below] != 0) count += subtree_count(tree, child, below);
  return count;
}

}  // namespace alidade::simd
