// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "octree/simd/subtree_count.h"

namespace alidade::simd {

/// Which slots of a node need not be visited for the k first points: boxes are exact at the lowest level, so
/// slots with equal boxes of one lattice position hold points that differ by their ids only, and node.h
/// promises the lowest ids in the first of them. Once k points stand in the slots before, the rest cannot
/// count. Keeps queries among a million equal points from looking at each. Requires a frame of level
/// k_min_frame_level.
inline unsigned slots_after_k_equal(const TreeView& tree, const Frame& frame, std::size_t k) {
  const Node& node = tree.nodes[frame.node];
  const auto is_one_place = [&](int slot) {
    return node.kind[slot] != 0 && node.low[0][slot] == node.high[0][slot] &&
           node.low[1][slot] == node.high[1][slot] && node.low[2][slot] == node.high[2][slot];
  };
  const auto equal = [&](int a, int b) {
    return node.low[0][a] == node.low[0][b] && node.low[1][a] == node.low[1][b] &&
           node.low[2][a] == node.low[2][b];
  };
  unsigned surplus = 0;
  // Children stand in Morton order, so equal ones stand side by side.
  std::size_t before = 0;
  for (int slot = 1; slot < k_node_width; ++slot) {
    if (!is_one_place(slot) || !is_one_place(slot - 1) || !equal(slot, slot - 1)) {
      before = 0;
      continue;
    }
    if (before < k) before += subtree_count(tree, frame, slot - 1);
    if (before >= k) surplus |= 1u << slot;
  }
  return surplus;
}

}  // namespace alidade::simd
