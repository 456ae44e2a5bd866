// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "octree/child_ranges.h"
#include "octree/leaf_writer.h"

namespace alidade {

/// What a TreeBuilder tells of the tree beside its arrays.
struct TreeSummary {
  StepBox box;
  int level_count = 0;
  std::uint32_t first_exact = 0;  ///< place; the number of points if all coordinates are exact
};

/// Makes nodes and leaves of sorted points. The top of the tree is made first, by one thread, down to
/// subtrees of bounded size; these are made side by side, and their nodes put behind those of the top in
/// order. So the result is the same for any number of threads. Leaves under frames above k_exact_frame_level
/// belong to the top; they take their places from the end of the order downwards, all others from its begin
/// upwards.
template <class Entry>
class TreeBuilder {
 public:
  /// Uses up the sorted points; there must be some. The arrays but for the nodes must have room for them.
  TreeBuilder(SortedPoints<Entry>& sorted, const SplitRules& rules, const LatticePosition& base,
              OctreeArrays& arrays)
      : sorted_(sorted),
        rules_(rules),
        arrays_(arrays),
        writer_(arrays, base),
        subtree_size_(std::max<std::size_t>(std::size_t{1} << 15, sorted.size() / 256)),
        exact_begin_(static_cast<std::uint32_t>(sorted.size())) {}

  TreeSummary build(int root_level) {
    top_.resize(1);
    build_top(point_range(sorted_, 0, exact_begin_), root_level, 0, 1);
    tbb::parallel_for(std::size_t{0}, subtrees_.size(), [&](std::size_t i) { build_subtree(subtrees_[i]); });
    join_nodes();
    TreeSummary summary;
    for (const StepBox& box : top_[0].boxes) summary.box.grow(box);
    summary.level_count = level_count_;
    for (const Subtree& subtree : subtrees_)
      summary.level_count = std::max(summary.level_count, subtree.level_count);
    summary.first_exact = exact_begin_;
    return summary;
  }

 private:
  /// A node whose boxes are not all known yet.
  struct Draft {
    Steps corner{};
    int level = 0;  ///< of the frame
    ChildList children;
    std::array<StepBox, k_node_width> boxes;
    std::uint32_t first_child = 0, first_point = 0;
  };

  struct Subtree {
    PointRange points;
    int level = 0;
    int depth = 0;           ///< levels of nodes down to the root, included
    std::uint32_t root = 0;  ///< place of the root among the nodes of the top
    std::uint32_t first_place = 0;
    std::vector<Node> nodes{};  ///< the root first; children counted from it
    StepBox box{};
    int level_count = 0;
  };

  void build_top(const PointRange& range, int level, std::uint32_t index, int depth) {
    Draft draft = draft_node(range, level);
    const std::uint32_t count = leaf_point_count(draft);
    if (level > k_exact_frame_level) {
      draft.first_point = exact_begin_ -= count;
    } else {
      draft.first_point = std::exchange(next_place_, next_place_ + count);
    }
    write_leaves(draft);
    for (const ChildRange& child : draft.children)
      if (child.is_leaf) sorted_.use_up(child.points.begin, child.points.end);
    draft.first_child = static_cast<std::uint32_t>(top_.size());
    level_count_ = std::max(level_count_, depth);
    top_.resize(top_.size() + inner_count(draft));
    top_[index] = draft;

    std::uint32_t child_index = draft.first_child;
    for (const ChildRange& child : draft.children) {
      if (child.is_leaf) continue;
      const int child_level = rules_.child_frame_level(child.points, level);
      if (child_level <= k_exact_frame_level && child.points.count() <= subtree_size_) {
        subtrees_.push_back({child.points, child_level, depth + 1, child_index, next_place_});
        next_place_ += child.points.count();
      } else {
        build_top(child.points, child_level, child_index, depth + 1);
      }
      ++child_index;
    }
  }

  void build_subtree(Subtree& subtree) {
    subtree.nodes.resize(1);
    subtree.box = build_node(subtree, subtree.points, subtree.level, 0, subtree.first_place, subtree.depth);
    sorted_.use_up(subtree.points.begin, subtree.points.end);
  }

  /// Builds the node for a range into subtree.nodes[index]; its points take the places from first_place on.
  StepBox build_node(Subtree& subtree, const PointRange& range, int level, std::size_t index,
                     std::uint32_t first_place, int depth) {
    Draft draft = draft_node(range, level);
    draft.first_point = first_place;
    write_leaves(draft);
    draft.first_child = static_cast<std::uint32_t>(subtree.nodes.size());
    subtree.nodes.resize(subtree.nodes.size() + inner_count(draft));
    subtree.level_count = std::max(subtree.level_count, depth);
    std::uint32_t place = first_place + leaf_point_count(draft);
    std::size_t child_index = draft.first_child;
    for (int slot = 0; slot < draft.children.count; ++slot) {
      const ChildRange& child = draft.children[slot];
      if (child.is_leaf) continue;
      draft.boxes[slot] = build_node(subtree, child.points, rules_.child_frame_level(child.points, level),
                                     child_index++, place, depth + 1);
      place += child.points.count();
    }
    subtree.nodes[index] = finished(draft);
    StepBox all;
    for (const StepBox& box : draft.boxes) all.grow(box);
    return all;
  }

  Draft draft_node(PointRange range, int level) {
    Draft draft;
    draft.level = level;
    draft.corner = steps_of(sorted_[range.begin]);
    for (std::uint32_t& c : draft.corner) c = level >= 32 ? 0 : c >> level << level;
    const bool has_sample =
        rules_.organisation == Organisation::layered && range.bit >= 0 && !rules_.is_small(range);
    if (!has_sample) {
      draft.children = choose_children(sorted_, range, rules_, level, k_node_width);
      return draft;
    }
    const std::uint32_t sample_end = move_sample_to_front(range);
    draft.children.add({point_range(sorted_, range.begin, sample_end), true});
    const ChildList below = choose_children(sorted_, point_range(sorted_, sample_end, range.end), rules_,
                                            level, k_node_width - 1);
    for (const ChildRange& child : below) draft.children.add({child.points, false});
    return draft;
  }

  /// Brings leaf_size points, evenly spaced in the range, to its front; all others keep their order. The end
  /// of the sample.
  std::uint32_t move_sample_to_front(const PointRange& range) {
    Entry* const points = sorted_.data() + range.begin;
    const auto sample_count = static_cast<std::uint32_t>(rules_.leaf_size);
    const auto place_of = [&](std::uint64_t i) {
      return (2 * i + 1) * range.count() / (2 * std::uint64_t{sample_count});
    };
    std::array<Entry, k_max_leaf_size> sample;
    for (std::uint32_t i = 0; i < sample_count; ++i) sample[i] = points[place_of(i)];
    std::uint64_t end = range.count();
    for (std::uint32_t i = sample_count; i-- > 0;) {
      std::move_backward(points + place_of(i) + 1, points + end, points + end + (sample_count - 1 - i));
      end = place_of(i);
    }
    std::move_backward(points, points + end, points + end + sample_count);
    std::copy_n(sample.begin(), sample_count, points);
    return range.begin + sample_count;
  }

  static std::uint32_t leaf_point_count(const Draft& draft) {
    std::uint32_t count = 0;
    for (const ChildRange& child : draft.children) count += child.is_leaf ? child.points.count() : 0;
    return count;
  }

  static std::size_t inner_count(const Draft& draft) {
    return static_cast<std::size_t>(std::count_if(draft.children.begin(), draft.children.end(),
                                                  [](const ChildRange& c) { return !c.is_leaf; }));
  }

  void write_leaves(Draft& draft) {
    std::uint32_t place = draft.first_point;
    for (int slot = 0; slot < draft.children.count; ++slot) {
      const ChildRange& child = draft.children[slot];
      if (!child.is_leaf) continue;
      draft.boxes[slot] = writer_.write(sorted_.data() + child.points.begin, child.points.count(),
                                        draft.corner, draft.level, place);
      place += child.points.count();
    }
  }

  Node finished(const Draft& draft) const {
    Node node{};
    node.first_child = draft.first_child;
    node.first_point = draft.first_point;
    for (int slot = 0; slot < draft.children.count; ++slot) {
      const auto grid_step = [&](std::uint32_t step, int axis) {
        return static_cast<std::uint8_t>((step - draft.corner[axis]) >> (draft.level - k_min_frame_level));
      };
      for (int axis = 0; axis < 3; ++axis) {
        node.low[axis][slot] = grid_step(draft.boxes[slot].low[axis], axis);
        node.high[axis][slot] = grid_step(draft.boxes[slot].high[axis], axis);
      }
      const ChildRange& child = draft.children[slot];
      node.kind[slot] = static_cast<std::uint8_t>(
          child.is_leaf ? child.points.count()
                        : k_inner_kind + draft.level - rules_.child_frame_level(child.points, draft.level));
    }
    return node;
  }

  /// Top, then the subtrees in order, each without its root, which stands in the top.
  void join_nodes() {
    std::vector<std::size_t> begin{top_.size()};
    for (const Subtree& subtree : subtrees_) begin.push_back(begin.back() + subtree.nodes.size() - 1);
    arrays_.nodes = HugeArray<Node>(begin.back());
    std::vector<StepBox> boxes(top_.size());
    tbb::parallel_for(std::size_t{0}, subtrees_.size(), [&](std::size_t i) {
      Subtree& subtree = subtrees_[i];
      for (Node& node : subtree.nodes) node.first_child += static_cast<std::uint32_t>(begin[i] - 1);
      arrays_.nodes[subtree.root] = subtree.nodes[0];
      std::copy(subtree.nodes.begin() + 1, subtree.nodes.end(), arrays_.nodes.data() + begin[i]);
      std::vector<Node>().swap(subtree.nodes);
      boxes[subtree.root] = subtree.box;
    });
    // Children stand behind their parents, so going backwards their boxes are known.
    for (std::size_t index = top_.size(); index-- > 0;) {
      Draft& draft = top_[index];
      if (draft.children.count == 0) continue;  // root of a subtree
      std::uint32_t child = draft.first_child;
      for (int slot = 0; slot < draft.children.count; ++slot) {
        if (!draft.children[slot].is_leaf) draft.boxes[slot] = boxes[child++];
        boxes[index].grow(draft.boxes[slot]);
      }
      arrays_.nodes[index] = finished(draft);
    }
  }

  SortedPoints<Entry>& sorted_;
  const SplitRules rules_;
  OctreeArrays& arrays_;
  const LeafWriter writer_;
  const std::size_t subtree_size_;
  std::uint32_t next_place_ = 0, exact_begin_;
  std::vector<Draft> top_;
  std::vector<Subtree> subtrees_;
  int level_count_ = 0;
};

}  // namespace alidade
