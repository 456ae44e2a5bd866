// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "octree/building/node_draft.h"

namespace alidade {

/// Chooses the nodes and leaves of an octree among the cells of a binary tree: every bit of the Morton key
/// splits a cell in two halves, and each node of the octree opens those that use its slots best. A ray is
/// expected to meet a box as often as its surface is large, so a node costs its area and a leaf its area by
/// vectors of points. The least cost of each cell in at most 1 .. k_node_width slots follows from those of
/// its halves (dynamic programming; Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs
/// through compressed wide BVHs", 2017, section 3).
template <class Entry>
class CollapsedTree {
 public:
  /// widening: lattice steps by which the sides of boxes count longer, as queries with a radius meet them.
  CollapsedTree(const SortedPoints<Entry>& sorted, const SplitRules& rules, float widening)
      : sorted_(sorted), rules_(rules), widening_(widening) {}

  /// Plans the tree over a range, which becomes cell 0. Ranges for which is_whole(range) is true take one
  /// slot and are not split. Cost: linear in the points; about 10 B per point until the next call.
  template <class IsWhole>
  void plan(const PointRange& range, const IsWhole& is_whole) {
    cells_.clear();
    add(range, is_whole);
  }

  /// The children of a node for this range, below a frame, in Morton order.
  ChildList children(const ChildRange& range, int frame_level) const {
    if (rules_.splits_by_number(range.points, frame_level))
      return split_by_number(sorted_, range, rules_, frame_level);
    ChildList children;
    const Cell& cell = cells_[range.cell];
    if (cell.upper_half == 0 || cell.is_leaf || !rules_.is_resolved(range.points, frame_level)) {
      children.add({range.points, rules_.fits_leaf(range.points, frame_level), range.cell});
      return children;
    }
    const int lower_slots = cell.lower_slots[0];
    gather(range.cell + 1, lower_slots, frame_level, children);
    gather(cell.upper_half, k_node_width - lower_slots, frame_level, children);
    return children;
  }

 private:
  /// The lower half of a cell is the next one.
  struct Cell {
    PointRange points;
    std::uint32_t upper_half = 0;  ///< number of its cell; 0: not split
    bool is_leaf = false;          ///< where it takes one slot
    /// By the slots that both halves share: those of the lower half, in [0] where the halves are the children
    /// of one node; 0: one slot less costs no more.
    std::array<std::uint8_t, k_node_width> lower_slots{};
    std::array<float, k_node_width> cost{};  ///< in at most index + 1 slots
    StepBox box;
  };

  // A node costs its area; a leaf a part of it, and more for each vector of 16 points. Measured on single
  // rays; the shares do not matter much.
  static constexpr float k_leaf_cost = 0.3f, k_vector_cost = 0.3f;

  float area(const StepBox& box) const {
    const auto side = [&](int axis) {
      return static_cast<float>(box.high[axis] - box.low[axis]) + widening_;
    };
    return side(0) * side(1) + side(1) * side(2) + side(2) * side(0);
  }

  float leaf_cost(const Cell& cell) const {
    const std::uint32_t vectors = (cell.points.count() + 15) / 16;
    return area(cell.box) * (k_leaf_cost + k_vector_cost * static_cast<float>(vectors));
  }

  template <class IsWhole>
  void add(const PointRange& range, const IsWhole& is_whole) {
    const auto index = static_cast<std::uint32_t>(cells_.size());
    cells_.emplace_back().points = range;
    const bool is_bottom = rules_.is_bottom(range);
    if (is_bottom || (!rules_.is_small(range) && is_whole(range))) {
      Cell& cell = cells_.back();
      grow_by_samples(cell.box, range, is_bottom ? 1 : std::max(1u, range.count() / 64));
      cell.is_leaf = is_bottom && rules_.is_small(range);
      cell.cost.fill(is_bottom ? leaf_cost(cell) : 0.0f);
      return;
    }
    const std::uint32_t middle = first_of_upper_half(sorted_, range);
    add(point_range(sorted_, range.begin, middle), is_whole);
    const auto upper_half = static_cast<std::uint32_t>(cells_.size());
    add(point_range(sorted_, middle, range.end), is_whole);
    cells_[index].upper_half = upper_half;
    choose(cells_[index], cells_[index + 1], cells_[upper_half]);
  }

  void grow_by_samples(StepBox& box, const PointRange& range, std::uint32_t stride) const {
    for (std::uint32_t i = range.begin; i < range.end; i += stride) box.grow(steps_of(sorted_[i]));
  }

  void choose(Cell& cell, const Cell& lower, const Cell& upper) const {
    cell.box.grow(lower.box);
    cell.box.grow(upper.box);
    std::array<float, k_node_width> split;  // cost of both halves in index + 1 slots
    std::array<std::int32_t, k_node_width> lower_slots;
    split.fill(std::numeric_limits<float>::infinity());
    // The inner loop runs along the slots of both, so that it is done several at a time.
    for (int k = 1; k < k_node_width; ++k) {
      for (int slots = k + 1; slots <= k_node_width; ++slots) {
        const float cost = lower.cost[k - 1] + upper.cost[slots - k - 1];
        const bool is_less = cost < split[slots - 1];
        split[slots - 1] = is_less ? cost : split[slots - 1];
        lower_slots[slots - 1] = is_less ? k : lower_slots[slots - 1];
      }
    }
    for (int slots = 2; slots <= k_node_width; ++slots)
      cell.lower_slots[slots % k_node_width] = static_cast<std::uint8_t>(lower_slots[slots - 1]);
    // The slots of a node are those of all its halves: [0] is kept for it and for all slots of its parent.
    const float node = area(cell.box) + split[k_node_width - 1];
    cell.is_leaf = rules_.may_be_leaf(cell.points) && leaf_cost(cell) <= node;
    cell.cost[0] = cell.is_leaf ? leaf_cost(cell) : node;
    for (int slots = 2; slots <= k_node_width; ++slots) {
      const bool pays = split[slots - 1] < cell.cost[slots - 2];
      cell.cost[slots - 1] = pays ? split[slots - 1] : cell.cost[slots - 2];
      if (!pays && slots < k_node_width) cell.lower_slots[slots] = 0;
    }
  }

  /// Appends the children that a cell in at most `slots` slots of a node becomes.
  void gather(std::uint32_t index, int slots, int frame_level, ChildList& children) const {
    const Cell& cell = cells_[index];
    while (slots > 1 && cell.lower_slots[slots] == 0) --slots;
    if (slots == 1 || !rules_.is_resolved(cell.points, frame_level)) {
      children.add({cell.points, cell.is_leaf && rules_.fits_leaf(cell.points, frame_level), index});
      return;
    }
    gather(index + 1, cell.lower_slots[slots], frame_level, children);
    gather(cell.upper_half, slots - cell.lower_slots[slots], frame_level, children);
  }

  const SortedPoints<Entry>& sorted_;
  const SplitRules& rules_;
  const float widening_;
  std::vector<Cell> cells_;
};

}  // namespace alidade
