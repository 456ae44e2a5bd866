// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "octree/octree.h"

// Going through an octree node by node in plain double arithmetic, for whatever is not worth lanes.

namespace alidade {

/// A node with its frame.
struct Frame {
  // Without initial values: searches have stacks of frames that would be filled for every query.
  std::uint32_t node;
  std::array<std::uint32_t, 3> corner;  ///< lattice steps from the tree's base
  int level;                            ///< of the frame: it is 2^level lattice steps wide
  int depth;                            ///< of the node, the root's being 0: the level of its points
};

/// A leaf: `count` points from storage index `first` on, below a frame.
struct Leaf {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::array<std::uint32_t, 3> corner{};
  int depth = 0;  ///< of the node: the level of its points (TreeView::level_count)
};

/// Requires a tree that is not empty.
inline Frame root_frame(const TreeView& tree) {
  return {0, {0, 0, 0}, tree.root_level, 0};
}

/// Frame of the inner child in this slot.
inline Frame child_frame(const TreeView& tree, const Frame& frame, int slot) {
  const Node& node = tree.nodes[frame.node];
  Frame child{node.first_child, frame.corner, frame.level, frame.depth + 1};
  for (int s = 0; s < slot; ++s) child.node += is_inner(node.kind[s]);
  const int drop = node.kind[slot] - k_inner_kind;
  for (int axis = 0; axis < 3; ++axis)
    child.corner[axis] += child_corner(node.low[axis][slot], frame.level, drop);
  child.level -= drop;
  return child;
}

/// The leaf in this slot.
inline Leaf child_leaf(const TreeView& tree, const Frame& frame, int slot) {
  const Node& node = tree.nodes[frame.node];
  Leaf leaf{node.first_point, node.kind[slot], frame.corner, frame.depth};
  for (int s = 0; s < slot; ++s) leaf.first += is_leaf(node.kind[s]) ? node.kind[s] : 0;
  return leaf;
}

/// Box in lattice steps from the root's corner, both ends inclusive.
struct SlotBox {
  std::array<std::int64_t, 3> low{}, high{};
};

/// Box of a child; every point below it lies inside.
inline SlotBox slot_box(const TreeView& tree, const Frame& frame, int slot) {
  const Node& node = tree.nodes[frame.node];
  const int shift = frame.level - k_min_frame_level;
  SlotBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t corner = frame.corner[axis];
    box.low[axis] = corner + (std::int64_t{node.low[axis][slot]} << shift);
    box.high[axis] = corner + ((std::int64_t{node.high[axis][slot]} + 1) << shift) - 1;
  }
  return box;
}

/// slot_box() in world coordinates.
inline Bounds child_bounds(const TreeView& tree, const Frame& frame, int slot) {
  const SlotBox box = slot_box(tree, frame, slot);
  const auto world = [&](int axis, std::int64_t steps) {
    return tree.lattice.offset[axis] +
           tree.lattice.scale[axis] * static_cast<double>(tree.base[axis] + steps);
  };
  Bounds bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.min[axis] = world(axis, box.low[axis]);
    bounds.max[axis] = world(axis, box.high[axis]);
  }
  return bounds;
}

/// Lattice position of the i-th point of a leaf.
inline LatticePosition position_of(const TreeView& tree, const Leaf& leaf, std::uint32_t i) {
  if (tree.positions && leaf.first >= tree.first_exact)
    return tree.positions[leaf.first - tree.first_exact + i];
  const std::uint16_t* coordinates = tree.coordinates + std::size_t{3} * leaf.first;
  LatticePosition position;
  for (int axis = 0; axis < 3; ++axis) {
    position[axis] = static_cast<std::int32_t>(static_cast<std::uint32_t>(tree.base[axis]) +
                                               leaf.corner[axis] + coordinates[axis * leaf.count + i]);
  }
  return position;
}

/// Visits every leaf once. Cost: linear; no recursion.
template <class Visit>
void for_each_leaf(const TreeView& tree, const Visit& visit) {
  if (tree.node_count == 0) return;
  std::vector<Frame> stack{root_frame(tree)};
  while (!stack.empty()) {
    const Frame frame = stack.back();
    stack.pop_back();
    for (int slot = 0; slot < k_node_width; ++slot) {
      const std::uint8_t kind = tree.nodes[frame.node].kind[slot];
      if (is_inner(kind)) stack.push_back(child_frame(tree, frame, slot));
      if (is_leaf(kind)) visit(child_leaf(tree, frame, slot));
    }
  }
}

/// Visits every leaf once, in parallel, some hundred in a row by one `worker = make_worker()`, which is
/// called with one leaf after another in the order of the tree. `progress` is in points, and is called
/// several times a second, however long a leaf takes.
template <class MakeWorker>
void for_each_leaf_in_parallel(const TreeView& tree, const Progress& progress,
                               const MakeWorker& make_worker) {
  constexpr std::size_t k_leaves_per_task = 1u << 8;
  // Fewer leaves would take as long as these, and leave threads idle.
  const std::size_t least = k_leaves_per_task * thread_count();
  PieceSize at_once({.first = std::max(4 * k_leaves_per_task, least),
                     .least = least,
                     .most = std::max(std::size_t{1} << 17, least),
                     .wanted = std::chrono::milliseconds(200)});
  std::vector<Leaf> leaves;
  std::uint64_t done = 0;
  report(progress, done, tree.point_count);
  const auto work = [&] {
    const PieceSize::Clock::time_point start = PieceSize::Clock::now();
    in_blocks(leaves.size(), k_leaves_per_task, [&](std::size_t first, std::size_t end) {
      auto worker = make_worker();
      for (std::size_t i = first; i < end; ++i) worker(leaves[i]);
    });
    at_once.learn(leaves.size(), PieceSize::Clock::now() - start);
    for (const Leaf& leaf : leaves) done += leaf.count;
    leaves.clear();
    report(progress, done, tree.point_count);
  };
  for_each_leaf(tree, [&](const Leaf& leaf) {
    leaves.push_back(leaf);
    if (leaves.size() >= at_once.next()) work();
  });
  if (!leaves.empty()) work();
}

/// Writes the positions of all points by point id. Cost: linear.
inline void put_positions(const TreeView& tree, LatticePosition* positions) {
  for_each_leaf(tree, [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i)
      positions[point_id(tree, leaf.first + i)] = position_of(tree, leaf, i);
  });
}

/// The positions of all points by point id: the cloud's, after build() took them out of it. Cost: linear,
/// 12 B per point.
inline std::vector<LatticePosition> positions_in_order(const TreeView& tree) {
  std::vector<LatticePosition> positions(tree.point_count);
  put_positions(tree, positions.data());
  return positions;
}

}  // namespace alidade
