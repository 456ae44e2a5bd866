// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <utility>

#include "base/huge_memory.h"
#include "cloud/sorted_points.h"
#include "octree/octree.h"

namespace alidade {

/// Box in lattice steps from the root's corner, inclusive; inverted when empty.
struct StepBox {
  Steps low{0xffffffffu}, high{0};

  void grow(const StepBox& box) {
    low = glm::min(low, box.low);
    high = glm::max(high, box.high);
  }
  void grow(const Steps& steps) { grow({steps, steps}); }
};

inline LatticePosition lattice_position(const LatticePosition& base, const Steps& steps) {
  return LatticePosition(Steps(base) + steps);
}

/// The arrays of an octree.
struct OctreeArrays {
  HugeArray<Node> nodes;
  HugeArray<std::uint16_t> coordinates;
  HugeArray<std::uint32_t> ids;
  /// By storage index, as long as the cloud, but only the pages from TreeView::first_exact on are ever used.
  HugeArray<LatticePosition> positions;
};

/// Packs points into the arrays; from many threads, for different storage indices.
class LeafWriter {
 public:
  LeafWriter(OctreeArrays& arrays, const LatticePosition& base) : arrays_(arrays), base_(base) {}

  /// Writes the points of a leaf below a frame, whose storage indices start at `first_point`. Their box.
  template <class Entry>
  StepBox write(const Entry* entries, std::uint32_t count, const Steps& corner, int frame_level,
                std::uint32_t first_point) const {
    StepBox box;
    const int shift = coordinate_shift(frame_level);
    std::uint16_t* const coordinates = arrays_.coordinates.data() + std::size_t{3} * first_point;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Steps steps = steps_of(entries[i]);
      for (int axis = 0; axis < 3; ++axis)
        coordinates[axis * count + i] = static_cast<std::uint16_t>((steps[axis] - corner[axis]) >> shift);
      arrays_.ids[first_point + i] = entries[i].id;
      if (shift > 0) arrays_.positions[first_point + i] = lattice_position(base_, steps);
      box.grow(steps);
    }
    return box;
  }

 private:
  OctreeArrays& arrays_;
  const LatticePosition base_;
};

// Which children a node gets: the only code in which the organisations differ, but for the samples of a
// layered one.

/// Sorted points below one node or in one leaf.
struct PointRange {
  std::uint32_t begin = 0, end = 0;
  int bit = -1;  ///< highest bit in which their keys differ; -1 if they have equal positions

  std::uint32_t count() const { return end - begin; }
  /// Of the smallest cell around the points.
  int level() const { return bit < 0 ? 0 : bit / 3 + 1; }
};

template <class Entry>
PointRange point_range(const SortedPoints<Entry>& sorted, std::uint32_t begin, std::uint32_t end) {
  return {begin, end, highest_bit(sorted[begin].key() ^ sorted[end - 1].key())};
}

struct ChildRange {
  PointRange points;
  bool is_leaf = false;
  std::uint32_t cell = 0;  ///< index in the CollapsedTree that planned it, if one did
};

/// The children of a node in the making.
struct ChildList {
  std::array<ChildRange, k_node_width> items{};
  int count = 0;

  void add(const ChildRange& child) { items[count++] = child; }
  ChildRange& operator[](int i) { return items[i]; }
  const ChildRange& operator[](int i) const { return items[i]; }
  auto begin() { return items.begin(); }
  auto end() { return items.begin() + count; }
  auto begin() const { return items.begin(); }
  auto end() const { return items.begin() + count; }
};

/// What decides about cells.
struct SplitRules {
  Organisation organisation = Organisation::adaptive;
  int leaf_size = k_max_leaf_size;
  int cell_level = 0;  ///< fixed: level of the grid's cells; otherwise 0

  /// Levels between a frame and its grid steps.
  static constexpr int k_frame_bits = 8;
  /// Up to so many points, exact positions take less memory than a further node.
  static constexpr std::uint32_t k_few_points = sizeof(Node) / sizeof(LatticePosition);

  bool is_small(const PointRange& range) const {
    return range.count() <= static_cast<std::uint32_t>(leaf_size);
  }

  /// Whether a range is too small to be split, or consists of one cell.
  bool is_bottom(const PointRange& range) const {
    if (organisation == Organisation::fixed) return !has_cells(range);
    return range.bit < 0 || range.count() <= static_cast<std::uint32_t>(std::max(1, 3 * leaf_size / 8));
  }

  /// Whether a range becomes a leaf where frames are small enough.
  bool may_be_leaf(const PointRange& range) const { return is_small(range) && !has_cells(range); }

  /// Whether a range that does not fit a leaf, or whose cell is too large for one, consists of smaller cells.
  bool has_cells(const PointRange& range) const {
    if (organisation == Organisation::fixed) return range.level() > cell_level;
    return range.bit >= 0 && !is_small(range);
  }

  /// Whether a range of few points becomes a leaf under this frame. 16 bits hold positions without loss up to
  /// frames of level 16; above, exact positions are stored where points are too sparse for smaller frames.
  bool fits_leaf(const PointRange& range, int frame_level) const {
    return may_be_leaf(range) && (frame_level <= k_exact_frame_level || range.level() > k_exact_frame_level ||
                                  range.count() <= k_few_points);
  }

  /// Nodes of a layered octree stay above the lowest level, except those of one position: there, equal boxes
  /// shall mean equal positions (Node in octree/octree.h).
  int lowest_frame_level(const PointRange& range) const {
    return organisation == Organisation::layered && range.bit >= 0 ? k_min_frame_level + 1
                                                                   : k_min_frame_level;
  }

  /// Whether parts of a range can be distinguished by boxes on the grid of this frame, or of any at all.
  bool is_resolved(const PointRange& range, int frame_level) const {
    return range.level() > frame_level - k_frame_bits || frame_level <= lowest_frame_level(range);
  }

  bool opens(const PointRange& range, int frame_level) const {
    return has_cells(range) && is_resolved(range, frame_level);
  }

  /// Points in one cell that are too many for a leaf are split by number.
  bool splits_by_number(const PointRange& range, int frame_level) const {
    return !is_small(range) && !has_cells(range) && is_resolved(range, frame_level);
  }

  /// Frame of the node for a range below a frame of this level.
  int child_frame_level(const PointRange& range, int frame_level) const {
    return std::max({lowest_frame_level(range), range.level(), frame_level - k_max_level_drop});
  }
};

/// Equal parts, as many as make leaves or as a node has slots; in Morton order, so that at the lowest level
/// only parts of one position can have equal boxes: where the bit is decided in which the first and the last
/// point of two parts differ, one of the boxes ends. Where they are not quite equal the smaller ones come
/// first: if only these are leaves, their points, which take the storage indices before those of inner
/// children, are the first in the order too.
template <class Entry>
ChildList split_by_number(const SortedPoints<Entry>& sorted, const ChildRange& range, const SplitRules& rules,
                          int frame_level) {
  ChildList parts;
  const std::uint32_t count = range.points.count();
  const auto leaf_size = static_cast<std::uint32_t>(rules.leaf_size);
  const std::uint32_t part_count = std::min<std::uint32_t>((count + leaf_size - 1) / leaf_size, k_node_width);
  const std::uint32_t size = count / part_count, larger_parts = count % part_count;
  std::uint32_t begin = range.points.begin;
  for (std::uint32_t part = 0; part < part_count; ++part) {
    const std::uint32_t end = begin + size + (part + larger_parts >= part_count ? 1 : 0);
    const PointRange points = point_range(sorted, begin, end);
    parts.add({points, rules.fits_leaf(points, frame_level), range.cell});
    begin = end;
  }
  return parts;
}

/// The first point of the upper half of a range: with the highest bit set in which keys differ. Requires
/// points that differ.
template <class Entry>
std::uint32_t first_of_upper_half(const SortedPoints<Entry>& sorted, const PointRange& range) {
  std::uint32_t low = range.begin, high = range.end - 1;  // the bit is clear at low and set at high
  while (high - low > 1) {
    const std::uint32_t middle = low + (high - low) / 2;
    ((sorted[middle].key() >> range.bit & 1) != 0 ? high : low) = middle;
  }
  return high;
}

/// At most `width` children for a range of a layered octree, in Morton order: cells are halved, the largest
/// first, until the slots are used, so that coarse levels have points everywhere. Requires range.count() > 0.
template <class Entry>
ChildList halve_largest(const SortedPoints<Entry>& sorted, const PointRange& range, const SplitRules& rules,
                        int frame_level, int width) {
  if (rules.splits_by_number(range, frame_level)) return split_by_number(sorted, {range}, rules, frame_level);
  ChildList children;
  children.add({range, rules.fits_leaf(range, frame_level)});
  const auto is_larger = [](const PointRange& a, const PointRange& b) {
    return a.bit != b.bit ? a.bit > b.bit : a.count() > b.count();
  };
  while (children.count < width) {
    int chosen = -1;
    for (int i = 0; i < children.count; ++i) {
      const PointRange& cell = children[i].points;
      if (rules.opens(cell, frame_level) && (chosen < 0 || is_larger(cell, children[chosen].points)))
        chosen = i;
    }
    if (chosen < 0) break;
    const PointRange cell = children[chosen].points;
    const std::uint32_t middle = first_of_upper_half(sorted, cell);
    const PointRange lower = point_range(sorted, cell.begin, middle),
                     upper = point_range(sorted, middle, cell.end);
    children[chosen] = {lower, rules.fits_leaf(lower, frame_level)};
    children.add({upper, rules.fits_leaf(upper, frame_level)});
  }
  std::sort(children.begin(), children.end(),
            [](const ChildRange& a, const ChildRange& b) { return a.points.begin < b.points.begin; });
  return children;
}

/// A node in the making: its children are chosen, their boxes may be missing yet.
struct NodeDraft {
  Steps corner{0};
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

  /// The node. Requires all boxes; `rules`: those the children were chosen by.
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
