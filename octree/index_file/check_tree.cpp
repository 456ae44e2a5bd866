// SPDX-License-Identifier: MIT
#include "octree/index_file/check_tree.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <algorithm>
#include <atomic>
#include <bit>
#include <mutex>
#include <vector>

#include "cloud/lattice.h"
#include "octree/spacing.h"
#include "octree/tree_walk.h"

namespace alidade {
namespace {

using Array = TreeFault::Array;

/// What find_broken_link() has found of a node when it comes to it.
struct Rank {
  std::uint8_t level = 0;  ///< 0: no parent has named it yet
  std::uint8_t depth = 0;  ///< 1: the root
};

/// Gives the inner children of a node their ranks. What is wrong; empty if nothing.
std::string rank_children(const TreeView& tree, std::uint32_t index, std::vector<Rank>& ranks) {
  const Node& node = tree.nodes[index];
  const Rank rank = ranks[index];
  std::uint64_t child = node.first_child;
  for (unsigned inner = inner_slots(node); inner != 0; inner &= inner - 1) {
    const int drop = node.kind[std::countr_zero(inner)] - k_inner_kind;
    if (child <= index || child >= tree.node_count)
      return fmt::format("invalid child; expected a later node below {}, found {}", tree.node_count, child);
    if (ranks[child].level != 0) return fmt::format("child {} also belongs to another node", child);
    if (drop > k_max_level_drop || rank.level - drop < k_min_frame_level)
      return fmt::format("child {} is {} levels below level {}", child, drop, rank.level);
    if (rank.depth == tree.level_count) return fmt::format("unexpected child on level {}", rank.depth);
    ranks[child++] = {static_cast<std::uint8_t>(rank.level - drop),
                      static_cast<std::uint8_t>(rank.depth + 1)};
  }
  return {};
}

std::string leaf_problem(const TreeView& tree, const Node& node, int level) {
  if (std::ranges::any_of(node.kind,
                          [](std::uint8_t kind) { return is_leaf(kind) && kind > k_max_leaf_size; }))
    return fmt::format("a leaf has more than {} points", k_max_leaf_size);
  const std::uint64_t begin = node.first_point, end = begin + leaf_counts(node).sum();
  if (end > tree.point_count)
    return fmt::format("its leaves end at a wrong storage index; expected {}, found {}", tree.point_count,
                       end);
  const bool has_exact_positions = tree.positions != nullptr && begin >= tree.first_exact;
  if (end > begin && coordinate_shift(level) > 0 && !has_exact_positions)
    return "its leaves require exact positions";
  return {};
}

/// Whether points below low frames are contiguous (Node in octree/octree.h): from the last node on, so that
/// children come before parents.
std::optional<TreeFault> find_scattered_points(const TreeView& tree, const std::vector<Rank>& ranks) {
  std::vector<std::uint32_t> ends(tree.node_count);  // past the last storage index below a node
  for (std::uint32_t index = tree.node_count; index-- > 0;) {
    if (ranks[index].level > k_exact_frame_level) continue;
    const Node& node = tree.nodes[index];
    std::uint32_t next_point = node.first_point + leaf_counts(node).sum();
    const auto inner = static_cast<std::uint32_t>(std::popcount(inner_slots(node)));
    for (std::uint32_t child = node.first_child; child < node.first_child + inner; ++child) {
      if (tree.nodes[child].first_point != next_point) {
        return TreeFault{Array::nodes, child,
                         fmt::format("its points begin at a wrong storage index; expected {}, found {}",
                                     next_point, tree.nodes[child].first_point)};
      }
      next_point = ends[child];
    }
    ends[index] = next_point;
  }
  return std::nullopt;
}

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

bool holds(const SlotBox& box, const SlotBox& other) {
  for (int axis = 0; axis < 3; ++axis)
    if (other.low[axis] < box.low[axis] || other.high[axis] > box.high[axis]) return false;
  return true;
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
  PointCheck(const TreeView& tree, const PointLayers& layers)
      : tree_(tree),
        layers_(layers),
        frames_(tree.node_count),
        indices_(tree.point_count),
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
      return TreeFault{Array::nodes, 0,
                       fmt::format("wrong number of levels: {} in the header, {} in the nodes",
                                   tree_.level_count, deepest_ + 1)};
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
                       fmt::format("wrong number of points in the leaves; expected {}, found {}",
                                   tree_.point_count, points_seen_.load())};
    }
    Bounds bounds;
    bounds.grow(to_world(tree_.lattice, extent.low));
    bounds.grow(to_world(tree_.lattice, extent.high));
    if (bounds.min == tree_.bounds.min && bounds.max == tree_.bounds.max) return std::nullopt;
    return TreeFault{Array::nodes, 0, "wrong bounds of the points"};
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

  /// What queries among points of one position rely on: the slots before hold the lower ids.
  void check_order_of_equal_slots(const Frame& frame) {
    const auto is_one_position = [](const SlotBox& box) { return box.low == box.high; };
    for (int slot = 1; slot < k_node_width; ++slot) {
      if (tree_.nodes[frame.node].kind[slot - 1] == 0 || tree_.nodes[frame.node].kind[slot] == 0) continue;
      const SlotBox before = slot_box(tree_, frame, slot - 1), box = slot_box(tree_, frame, slot);
      if (!is_one_position(before) || !is_one_position(box) || before.low != box.low) continue;
      const std::uint64_t highest = ids_below(frame, slot - 1).high, lowest = ids_below(frame, slot).low;
      if (layers_.spacings && slot_spacing(frame, slot - 1) != slot_spacing(frame, slot)) {
        first_.add(frame.node, {Array::slot_spacings,
                                std::uint64_t{k_node_width} * frame.node + static_cast<unsigned>(slot),
                                "slots with equal positions have different spacings"});
      }
      if (highest < lowest) continue;
      first_.add(frame.node,
                 {Array::nodes, frame.node,
                  fmt::format("slots with equal positions are not sorted by id: slot {}, before slot "
                              "{}, has id {}, after id {}",
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
        const std::uint64_t id = point_id(tree_, leaf.first + i);
        ids.grow({id, id});
      }
    }
    return ids;
  }

  void check_child(const Frame& frame, int slot) {
    const SlotBox box = slot_box(tree_, frame, slot);
    const Frame& child = frames_[child_frame(tree_, frame, slot).node];
    for (int inner = 0; inner < k_node_width; ++inner) {
      if (tree_.nodes[child.node].kind[inner] == 0 || holds(box, slot_box(tree_, child, inner))) continue;
      first_.add(frame.node,
                 {Array::nodes, frame.node,
                  fmt::format("its box in slot {} does not contain the boxes of its child", slot)});
    }
  }

  std::uint16_t slot_spacing(const Frame& frame, int slot) const {
    return layers_.slot_spacings[std::size_t{k_node_width} * frame.node + static_cast<unsigned>(slot)];
  }

  void check_spacings(const Frame& frame, const SlotBox& box, const Leaf& leaf) {
    constexpr std::uint16_t k_infinite = 0x7f80;
    const bool is_one_position = frame.level == k_min_frame_level && box.low == box.high;
    for (std::uint32_t index = leaf.first; index < leaf.first + leaf.count; ++index) {
      if (layers_.spacings[index] == 0 || layers_.spacings[index] > k_infinite)
        first_.add(frame.node, {Array::spacings, index, "the spacing is not positive"});
      if (is_one_position && layers_.spacings[index] != layers_.spacings[leaf.first])
        first_.add(frame.node,
                   {Array::spacings, index, "points with equal positions have different spacings"});
    }
  }

  void check_leaf(const Frame& frame, int slot, LatticeExtent& extent) {
    const SlotBox box = slot_box(tree_, frame, slot);
    const Leaf leaf = child_leaf(tree_, frame, slot);
    if (layers_.spacings) check_spacings(frame, box, leaf);
    points_seen_.fetch_add(leaf.count, std::memory_order_relaxed);
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const std::uint32_t index = leaf.first + i;
      const LatticePosition position = position_of(tree_, leaf, i);
      extent.grow(position);
      SlotBox point;
      for (int axis = 0; axis < 3; ++axis)
        point.low[axis] = point.high[axis] =
            static_cast<std::uint32_t>(position[axis]) - static_cast<std::uint32_t>(tree_.base[axis]);
      const bool is_exact = tree_.positions && leaf.first >= tree_.first_exact;
      if (!holds(box, point))
        first_.add(frame.node, {is_exact ? Array::positions : Array::coordinates,
                                is_exact ? index - tree_.first_exact : index,
                                "the point is outside the box of its leaf"});
      if (is_exact && !has_right_coordinates(frame, leaf, i, point))
        first_.add(frame.node,
                   {Array::coordinates, index, "the coordinates do not match the exact position"});
      if (!indices_.set(index))
        first_.add(frame.node,
                   {Array::nodes, frame.node, fmt::format("storage index {} is in two leaves", index)});
      if (tree_.ids && !ids_.set(tree_.ids[index]))
        first_.add(frame.node, {Array::ids, index, fmt::format("duplicate id {}", tree_.ids[index])});
    }
  }

  bool has_right_coordinates(const Frame& frame, const Leaf& leaf, std::uint32_t i,
                             const SlotBox& point) const {
    const std::uint16_t* const coordinates = tree_.coordinates + std::size_t{3} * leaf.first;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t steps = point.low[axis] - std::int64_t{frame.corner[axis]};
      if (coordinates[axis * leaf.count + i] != steps >> coordinate_shift(frame.level)) return false;
    }
    return true;
  }

  const TreeView& tree_;
  const PointLayers& layers_;
  std::vector<Frame> frames_;
  int deepest_ = 0;
  Marks indices_, ids_;
  std::atomic<std::uint64_t> points_seen_ = 0;
  FirstFault first_;
};

}  // namespace

std::optional<TreeFault> find_broken_link(const TreeView& tree) {
  if (tree.node_count == 0) return std::nullopt;
  std::vector<Rank> ranks(tree.node_count);
  ranks[0] = {static_cast<std::uint8_t>(tree.root_level), 1};
  for (std::uint32_t index = 0; index < tree.node_count; ++index) {
    std::string problem =
        ranks[index].level == 0 ? "it is not a child of an earlier node" : rank_children(tree, index, ranks);
    if (problem.empty()) problem = leaf_problem(tree, tree.nodes[index], ranks[index].level);
    if (!problem.empty()) return TreeFault{Array::nodes, index, std::move(problem)};
  }
  return find_scattered_points(tree, ranks);
}

std::optional<TreeFault> find_bad_id(std::span<const std::uint32_t> ids, std::uint64_t point_count) {
  std::uint32_t highest = 0;
  for (const std::uint32_t id : ids) highest = std::max(highest, id);
  if (ids.empty() || highest < point_count) return std::nullopt;
  const auto bad = std::ranges::find_if(ids, [&](std::uint32_t id) { return id >= point_count; });
  return TreeFault{Array::ids, static_cast<std::uint64_t>(bad - ids.begin()),
                   fmt::format("id out of range; expected less than {}, found {}", point_count, *bad)};
}

std::optional<TreeFault> find_misplaced_point(const TreeView& tree, const PointLayers& layers) {
  if (tree.node_count == 0) return std::nullopt;
  return PointCheck(tree, layers).run();
}

std::optional<TreeFault> find_bad_slot_spacing(const TreeView& tree, const PointLayers& layers) {
  for (std::uint32_t index = 0; index < tree.node_count; ++index) {
    const auto greatest = greatest_spacings(tree, layers, index);
    for (int slot = 0; slot < k_node_width; ++slot) {
      const std::uint64_t at = std::uint64_t{k_node_width} * index + static_cast<unsigned>(slot);
      if (layers.slot_spacings[at] == greatest[slot]) continue;
      return TreeFault{
          Array::slot_spacings, at,
          fmt::format("wrong largest spacing of slot {} of node {}; expected {:.9g}, found {:.9g}", slot,
                      index, spacing_of(greatest[slot]), spacing_of(layers.slot_spacings[at]))};
    }
  }
  return std::nullopt;
}

}  // namespace alidade
