// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <vector>

#include "octree/index_file/check_tree.h"
#include "cloud/lattice.h"
#include "octree/slot_spacings.h"
#include "octree/tree_walk.h"

namespace alidade {
namespace {

using Array = TreeFault::Array;

constexpr std::size_t k_nodes_per_task = 1024;

/// Bits that threads set.
class Marks {
 public:
  explicit Marks(std::size_t count) : words_((count + 63) / 64) {}
  /// Whether the bit was not set before.
  bool set(std::size_t index) {
    const std::uint64_t bit = std::uint64_t{1} << (index % 64);
    return (words_[index / 64].fetch_or(bit, std::memory_order_relaxed) & bit) == 0;
  }

 private:
  std::vector<std::atomic<std::uint64_t>> words_;
};

/// Keeps the fault of the lowest node, so that threads agree on one.
class FirstFault {
 public:
  void add(std::uint32_t node, TreeFault fault) {
    const std::scoped_lock lock(mutex_);
    if (fault_ && node_ <= node) return;
    node_ = node;
    fault_ = std::move(fault);
  }
  const std::optional<TreeFault>& get() const { return fault_; }

 private:
  std::mutex mutex_;
  std::uint32_t node_ = 0;
  std::optional<TreeFault> fault_;
};

/// Box in lattice steps from the root's corner, both ends inclusive.
struct StepBox {
  std::array<std::int64_t, 3> low, high;

  bool holds(const StepBox& other) const {
    for (int axis = 0; axis < 3; ++axis)
      if (other.low[axis] < low[axis] || other.high[axis] > high[axis]) return false;
    return true;
  }
};

StepBox slot_box(const TreeView& tree, const Frame& frame, int slot) {
  const Node& node = tree.nodes[frame.node];
  const int shift = frame.level - k_min_frame_level;
  StepBox box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = std::int64_t{frame.corner[axis]} + (std::int64_t{node.low[axis][slot]} << shift);
    box.high[axis] =
        std::int64_t{frame.corner[axis]} + ((std::int64_t{node.high[axis][slot]} + 1) << shift) - 1;
  }
  return box;
}

/// Lowest and highest of some ids.
struct IdRange {
  std::uint64_t low = ~std::uint64_t{0}, high = 0;

  void grow(const IdRange& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
};

class PointCheck {
 public:
  explicit PointCheck(const TreeView& tree)
      : tree_(tree),
        frames_(tree.node_count),
        places_(tree.point_count),
        ids_(tree.ids ? tree.point_count : 0) {
    frames_[0] = root_frame(tree);
    for (std::uint32_t index = 0; index < tree.node_count; ++index) {
      for (int slot = 0; slot < k_node_width; ++slot) {
        if (!is_inner(tree.nodes[index].kind[slot])) continue;
        const Frame child = child_frame(tree, frames_[index], slot);
        frames_[child.node] = child;
        deepest_ = std::max(deepest_, child.depth);
      }
    }
  }

  std::optional<TreeFault> run() {
    if (deepest_ + 1 != tree_.level_count) {
      return TreeFault{
          Array::nodes, 0,
          fmt::format("the header has {} levels, the nodes {}", tree_.level_count, deepest_ + 1)};
    }
    const tbb::blocked_range<std::uint32_t> all(0, tree_.node_count, k_nodes_per_task);
    const LatticeExtent extent = tbb::parallel_reduce(
        all, LatticeExtent{},
        [&](const tbb::blocked_range<std::uint32_t>& range, LatticeExtent part) {
          for (std::uint32_t index = range.begin(); index != range.end(); ++index) check_node(index, part);
          return part;
        },
        [](LatticeExtent a, const LatticeExtent& b) {
          a.grow(b);
          return a;
        });
    if (first_.get()) return first_.get();
    if (points_seen_ != tree_.point_count) {
      return TreeFault{Array::nodes, 0,
                       fmt::format("the leaves should hold {} points but hold {}", tree_.point_count,
                                   points_seen_.load())};
    }
    Bounds bounds;
    bounds.grow(to_world(tree_.lattice, extent.low));
    bounds.grow(to_world(tree_.lattice, extent.high));
    if (bounds.min == tree_.bounds.min && bounds.max == tree_.bounds.max) return std::nullopt;
    return TreeFault{Array::nodes, 0, "the bounds are not those of the points"};
  }

 private:
  void check_node(std::uint32_t index, LatticeExtent& extent) {
    const Frame& frame = frames_[index];
    for (int slot = 0; slot < k_node_width; ++slot) {
      const std::uint8_t kind = tree_.nodes[index].kind[slot];
      if (is_inner(kind)) check_child(frame, slot);
      if (is_leaf(kind)) check_leaf(frame, slot, extent);
    }
    if (frame.level == k_min_frame_level) check_order_of_equal_slots(frame);
  }

  /// What queries among points of one place rely on: the slots before hold the lower ids.
  void check_order_of_equal_slots(const Frame& frame) {
    const auto is_one_place = [](const StepBox& box) { return box.low == box.high; };
    for (int slot = 1; slot < k_node_width; ++slot) {
      if (tree_.nodes[frame.node].kind[slot - 1] == 0 || tree_.nodes[frame.node].kind[slot] == 0) continue;
      const StepBox before = slot_box(tree_, frame, slot - 1), box = slot_box(tree_, frame, slot);
      if (!is_one_place(before) || !is_one_place(box) || before.low != box.low) continue;
      const std::uint64_t highest = ids_below(frame, slot - 1).high, lowest = ids_below(frame, slot).low;
      if (tree_.spacings && slot_spacing(frame, slot - 1) != slot_spacing(frame, slot)) {
        first_.add(frame.node, {Array::slot_spacings,
                                std::uint64_t{k_node_width} * frame.node + static_cast<unsigned>(slot),
                                "two slots of one place have different spacings"});
      }
      if (highest < lowest) continue;
      first_.add(frame.node,
                 {Array::nodes, frame.node,
                  fmt::format("of two slots of one place, slot {} should have lower ids than slot "
                              "{} but has id {} beside {}",
                              slot - 1, slot, highest, lowest)});
    }
  }

  IdRange ids_below(const Frame& frame, int slot) const {
    IdRange ids;
    if (is_inner(tree_.nodes[frame.node].kind[slot])) {
      const Frame& child = frames_[child_frame(tree_, frame, slot).node];
      for (int inner = 0; inner < k_node_width; ++inner) ids.grow(ids_below(child, inner));
    } else {
      const Leaf leaf = child_leaf(tree_, frame, slot);
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const std::uint64_t id = point_id(tree_, leaf.place + i);
        ids.grow({id, id});
      }
    }
    return ids;
  }

  void check_child(const Frame& frame, int slot) {
    const StepBox box = slot_box(tree_, frame, slot);
    const Frame& child = frames_[child_frame(tree_, frame, slot).node];
    for (int inner = 0; inner < k_node_width; ++inner) {
      if (tree_.nodes[child.node].kind[inner] == 0 || box.holds(slot_box(tree_, child, inner))) continue;
      first_.add(frame.node, {Array::nodes, frame.node,
                              fmt::format("its box in slot {} does not hold the boxes of its child", slot)});
    }
  }

  std::uint16_t slot_spacing(const Frame& frame, int slot) const {
    return slot_spacings(tree_, frame.node)[slot];
  }

  void check_spacings(const Frame& frame, const StepBox& box, const Leaf& leaf) {
    constexpr std::uint16_t k_infinite = 0x7f80;
    const bool is_one_place = frame.level == k_min_frame_level && box.low == box.high;
    for (std::uint32_t place = leaf.place; place < leaf.place + leaf.count; ++place) {
      if (tree_.spacings[place] > k_infinite)
        first_.add(frame.node, {Array::spacings, place, "the spacing is negative or no number"});
      if (is_one_place && tree_.spacings[place] != tree_.spacings[leaf.place])
        first_.add(frame.node, {Array::spacings, place, "two points of one place have different spacings"});
    }
  }

  void check_leaf(const Frame& frame, int slot, LatticeExtent& extent) {
    const StepBox box = slot_box(tree_, frame, slot);
    const Leaf leaf = child_leaf(tree_, frame, slot);
    if (tree_.spacings) check_spacings(frame, box, leaf);
    points_seen_.fetch_add(leaf.count, std::memory_order_relaxed);
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const std::uint32_t place = leaf.place + i;
      const LatticePosition position = position_of(tree_, leaf, i);
      extent.grow(position);
      StepBox point{};
      for (int axis = 0; axis < 3; ++axis)
        point.low[axis] = point.high[axis] =
            static_cast<std::uint32_t>(position[axis]) - static_cast<std::uint32_t>(tree_.base[axis]);
      const bool is_exact = tree_.positions && leaf.place >= tree_.first_exact;
      if (!box.holds(point))
        first_.add(frame.node, {is_exact ? Array::positions : Array::coordinates,
                                is_exact ? place - tree_.first_exact : place,
                                "the point lies outside the box of its leaf"});
      if (is_exact && !has_right_coordinates(frame, leaf, i, point))
        first_.add(frame.node, {Array::coordinates, place, "the coordinates are not those of the position"});
      if (!places_.set(place))
        first_.add(frame.node,
                   {Array::nodes, frame.node, fmt::format("place {} stands in two leaves", place)});
      if (tree_.ids && !ids_.set(tree_.ids[place]))
        first_.add(frame.node, {Array::ids, place, fmt::format("id {} occurs twice", tree_.ids[place])});
    }
  }

  bool has_right_coordinates(const Frame& frame, const Leaf& leaf, std::uint32_t i,
                             const StepBox& point) const {
    const std::uint16_t* const coordinates = tree_.coordinates + std::size_t{3} * leaf.place;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t steps = point.low[axis] - std::int64_t{frame.corner[axis]};
      if (coordinates[axis * leaf.count + i] != steps >> coordinate_shift(frame.level)) return false;
    }
    return true;
  }

  const TreeView& tree_;
  std::vector<Frame> frames_;
  int deepest_ = 0;
  Marks places_, ids_;
  std::atomic<std::uint64_t> points_seen_ = 0;
  FirstFault first_;
};

}  // namespace

std::optional<TreeFault> find_misplaced_point(const TreeView& tree) {
  if (tree.node_count == 0) return std::nullopt;
  return PointCheck(tree).run();
}

std::optional<TreeFault> find_bad_slot_spacing(const TreeView& tree) {
  for (std::uint32_t index = 0; index < tree.node_count; ++index) {
    const auto greatest = greatest_spacings(tree, tree.slot_spacings, index);
    for (int slot = 0; slot < k_node_width; ++slot) {
      const std::uint64_t at = std::uint64_t{k_node_width} * index + static_cast<unsigned>(slot);
      if (tree.slot_spacings[at] == greatest[slot]) continue;
      return TreeFault{
          Array::slot_spacings, at,
          fmt::format("the greatest spacing below slot {} of node {} should be {:.9g} but is {:.9g}", slot,
                      index, spacing_of(greatest[slot]), spacing_of(tree.slot_spacings[at]))};
    }
  }
  return std::nullopt;
}

}  // namespace alidade
