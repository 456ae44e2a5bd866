// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>

namespace alidade {

/// A node: up to eight children with their boxes, one cache line.
///
///   byte  0      8      16     24     32     40     48     56           60
///         low.x  low.y  low.z  high.x high.y high.z kind   first_child  first_point
///         8 B    8 B    8 B    8 B    8 B    8 B    8 B    4 B          4 B
///
/// Every node has a *frame*: a cell of the octree, 2^level lattice steps wide, level >= 8, whose lower corner
/// is a multiple of its width. The children's boxes stand on the frame's own grid of 256 steps per axis; one
/// grid step is 2^(level - 8) lattice steps, so boxes are exact at level 8. low and high are inclusive grid
/// steps. A node does not store its frame: the root's is known, and a child's follows from its parent's
/// (child_corner).
///
/// Children need not be the eight octants of one split: levels of the octree are collapsed until the eight
/// slots are used. Their cells are disjoint and stand in Morton order. Exceptions: points that are too many
/// for a leaf but stand in a cell that is not split further are divided by number, in Morton order; and in a
/// layered octree the first slot may be a leaf with a sample of the points of the whole cell. At level 8,
/// slots with equal boxes hold points of one place only, in any organisation; the lowest ids are in the first
/// of them.
///
/// From frames of level 16 (k_exact_frame_level) on, the points below a node stand one after another: those
/// of its leaves, then those below its inner children in slot order.
struct alignas(64) Node {
  std::uint8_t low[3][8];
  std::uint8_t high[3][8];
  /// 0: empty slot. 1..127: leaf with so many points. 128 + d: inner node whose frame is d levels smaller, d
  /// = 0..7.
  std::uint8_t kind[8];
  /// Inner children stand one after another in slot order from here.
  std::uint32_t first_child;
  /// Points of leaf children stand one after another in slot order from here.
  std::uint32_t first_point;
};
static_assert(sizeof(Node) == 64);

constexpr int k_node_width = 8;
constexpr std::uint8_t k_inner_kind = 0x80;
constexpr int k_max_level_drop = 7;
constexpr int k_min_frame_level = 8;
constexpr int k_max_leaf_size = 32;

/// Nodes on the longest possible way down. Adaptive and fixed octrees: 24 for frames from level 32 down to 9,
/// 8 for cells below a frame of level 8, 11 that split points of one cell by number. Layered ones: each node
/// takes at least two of the 96 bits of a position, or drops the frame by seven levels (three times at most,
/// once more down to level 8), and 11 again.
constexpr int k_max_tree_depth = 48 + 4 + 11;

constexpr bool is_inner(std::uint8_t kind) {
  return kind >= k_inner_kind;
}
constexpr bool is_leaf(std::uint8_t kind) {
  return kind != 0 && kind < k_inner_kind;
}

/// Lattice steps from the corner of the parent's frame to the corner of the child's, along one axis.
/// low: the child's grid step in the parent; level: of the parent's frame; drop: level difference.
constexpr std::uint32_t child_corner(std::uint8_t low, int level, int drop) {
  const std::uint32_t cell_mask = ~((256u >> drop) - 1u);
  return (low & cell_mask) << (level - k_min_frame_level);
}

}  // namespace alidade
