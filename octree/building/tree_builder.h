// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "octree/building/collapsed_tree.h"

namespace alidade {

/// What a tree has beside its arrays.
struct TreeSummary {
  StepBox box;
  int level_count = 0;
  std::uint32_t first_exact = 0;  ///< storage index; the number of points if all coordinates are exact
};

/// Makes nodes and leaves of sorted points. The top of the tree is made first, by one thread, down to
/// subtrees of bounded size; these are made side by side, and their nodes put behind those of the top in
/// order. So the result is the same for any number of threads. Leaves under frames above k_exact_frame_level
/// belong to the top; they take their storage indices from the end of the order downwards, all others from
/// its begin upwards.
template <class Entry>
class TreeBuilder {
 public:
  /// Uses up the sorted points; there must be some. The arrays but for the nodes must have room for them;
  /// those lie in `scratch`.
  TreeBuilder(SortedPoints<Entry>& sorted, const SplitRules& rules, const LatticePosition& base,
              OctreeArrays& arrays, const ScratchFolder& scratch = {})
      : sorted_(sorted),
        rules_(rules),
        arrays_(arrays),
        scratch_(scratch),
        writer_(arrays, base),
        subtree_size_(std::max<std::size_t>(std::size_t{1} << 15, sorted.size() / 256)),
        widening_(usual_width()),
        exact_begin_(static_cast<std::uint32_t>(sorted.size())) {}

  TreeSummary build(int root_level) {
    top_.resize(1);
    top_boxes_.resize(1);
    const PointRange all = point_range(sorted_, 0, exact_begin_);
    CollapsedTree<Entry> plan(sorted_, rules_, widening_);
    if (is_planned())
      plan.plan(all, [&](const PointRange& range) { return is_subtree(range, range.level()); });
    build_top(plan, {all}, root_level, 0, 1);
    make_batches();
    in_parallel(batches_.size(), 1, [&](std::size_t i) { build_batch(batches_[i]); });
    finish_top();
    join_nodes();
    TreeSummary summary{top_boxes_[0], level_count_, exact_begin_};
    for (const Batch& batch : batches_)
      summary.level_count = std::max(summary.level_count, batch.level_count);
    return summary;
  }

 private:
  /// A node of the top above subtrees, which has to wait for their boxes.
  struct Waiting {
    std::uint32_t index = 0;
    NodeDraft draft;
  };

  struct Subtree {
    PointRange points;
    int level = 0;
    int depth = 0;                  ///< nodes from the tree's root to this one's
    std::uint32_t root = 0;         ///< number among the nodes of the top
    std::uint32_t first_point = 0;  ///< storage index
  };

  /// Subtrees that are made in one go, so that many small ones cost no more than few large ones.
  struct Batch {
    std::size_t first = 0, end = 0;  ///< among the subtrees
    std::vector<Node> nodes{};       ///< the roots, then all others; children counted from the first root
    int level_count = 0;
  };

  /// Layered octrees choose children node by node, since each takes a sample out.
  bool is_planned() const { return rules_.organisation != Organisation::layered; }

  bool is_subtree(const PointRange& range, int frame_level) const {
    return frame_level <= k_exact_frame_level && range.count() <= subtree_size_;
  }

  /// Lattice steps across the cells that hold about eight points, as the median of samples; at least one
  /// step. A query whose spheres close the surface widens boxes by about as much.
  float usual_width() const {
    constexpr std::size_t k_samples = 1023, k_points = 16;
    std::vector<int> bits;
    if (sorted_.size() <= k_points) return 1.0f;
    const std::size_t last = sorted_.size() - 1 - k_points;
    for (std::size_t sample = 0; sample < k_samples; ++sample) {
      const std::size_t i = last * sample / (k_samples - 1);
      bits.push_back(highest_bit(sorted_[i].key() ^ sorted_[i + k_points].key()));
    }
    std::ranges::nth_element(bits, bits.begin() + k_samples / 2);
    return std::exp2(static_cast<float>(bits[k_samples / 2]) / 3.0f - 0.5f) + 1.0f;
  }

  /// Whether the node has its box: no subtree is below.
  bool build_top(const CollapsedTree<Entry>& plan, const ChildRange& range, int level, std::uint32_t index,
                 int depth) {
    NodeDraft draft = draft_node(plan, range, level);
    const std::uint32_t count = draft.leaf_point_count();
    if (level > k_exact_frame_level) {
      draft.first_point = exact_begin_ -= count;
    } else {
      draft.first_point = std::exchange(next_point_, next_point_ + count);
    }
    write_leaves(draft);
    for (const ChildRange& child : draft.children)
      if (child.is_leaf) sorted_.use_up(child.points.begin, child.points.end);
    draft.first_child = static_cast<std::uint32_t>(top_.size());
    level_count_ = std::max(level_count_, depth);
    top_.resize(top_.size() + draft.inner_count());
    top_boxes_.resize(top_.size());

    bool is_known = true;
    std::uint32_t child_index = draft.first_child;
    for (int slot = 0; slot < draft.children.count; ++slot) {
      const ChildRange& child = draft.children[slot];
      if (child.is_leaf) continue;
      const int child_level = rules_.child_frame_level(child.points, level);
      if (is_subtree(child.points, child_level)) {
        subtrees_.push_back({child.points, child_level, depth + 1, child_index, next_point_});
        next_point_ += child.points.count();
        is_known = false;
      } else {
        is_known &= build_top(plan, child, child_level, child_index, depth + 1);
        draft.boxes[slot] = top_boxes_[child_index];
      }
      ++child_index;
    }
    if (is_known) {
      top_[index] = draft.node(rules_);
      top_boxes_[index] = draft.box();
    } else {
      waiting_.push_back({index, draft});
    }
    return is_known;
  }

  void make_batches() {
    std::size_t points = 0;
    for (std::size_t i = 0; i < subtrees_.size(); ++i) {
      if (batches_.empty() || points + subtrees_[i].points.count() > subtree_size_) {
        batches_.push_back({i, i});
        points = 0;
      }
      batches_.back().end = i + 1;
      points += subtrees_[i].points.count();
    }
  }

  void build_batch(Batch& batch) {
    batch.nodes.resize(batch.end - batch.first);
    CollapsedTree<Entry> plan(sorted_, rules_, widening_);
    for (std::size_t i = batch.first; i < batch.end; ++i) {
      const Subtree& subtree = subtrees_[i];
      if (is_planned()) plan.plan(subtree.points, [](const PointRange&) { return false; });
      top_boxes_[subtree.root] = build_node(batch, plan, {subtree.points}, subtree.level, i - batch.first,
                                            subtree.first_point, subtree.depth);
      sorted_.use_up(subtree.points.begin, subtree.points.end);
    }
  }

  /// Builds the node for a range into batch.nodes[index]; its points take the storage indices from
  /// first_point on.
  StepBox build_node(Batch& batch, const CollapsedTree<Entry>& plan, const ChildRange& range, int level,
                     std::size_t index, std::uint32_t first_point, int depth) {
    NodeDraft draft = draft_node(plan, range, level);
    draft.first_point = first_point;
    write_leaves(draft);
    draft.first_child = static_cast<std::uint32_t>(batch.nodes.size());
    batch.nodes.resize(batch.nodes.size() + draft.inner_count());
    batch.level_count = std::max(batch.level_count, depth);
    std::uint32_t next_point = first_point + draft.leaf_point_count();
    std::size_t child_index = draft.first_child;
    for (int slot = 0; slot < draft.children.count; ++slot) {
      const ChildRange& child = draft.children[slot];
      if (child.is_leaf) continue;
      draft.boxes[slot] = build_node(batch, plan, child, rules_.child_frame_level(child.points, level),
                                     child_index++, next_point, depth + 1);
      next_point += child.points.count();
    }
    batch.nodes[index] = draft.node(rules_);
    return draft.box();
  }

  NodeDraft draft_node(const CollapsedTree<Entry>& plan, const ChildRange& range, int level) {
    const PointRange& points = range.points;
    NodeDraft draft;
    draft.level = level;
    if (level < 32) draft.corner = steps_of(sorted_[points.begin]) >> Steps(level) << Steps(level);
    if (is_planned()) {
      draft.children = plan.children(range, level);
    } else if (points.bit < 0 || rules_.is_small(points)) {
      draft.children = halve_largest(sorted_, points, rules_, level, k_node_width);
    } else {
      const std::uint32_t sample_end = move_sample_to_front(points);
      draft.children.add({point_range(sorted_, points.begin, sample_end), true});
      // More children would leave fewer levels to choose from.
      constexpr int k_parts = 7;
      const ChildList below =
          halve_largest(sorted_, point_range(sorted_, sample_end, points.end), rules_, level, k_parts);
      for (const ChildRange& child : below) draft.children.add({child.points, false});
    }
    return draft;
  }

  /// Brings leaf_size points, evenly spaced in the range, to its front; all others keep their order. The end
  /// of the sample.
  std::uint32_t move_sample_to_front(const PointRange& range) {
    Entry* const points = sorted_.data() + range.begin;
    const auto sample_count = static_cast<std::uint32_t>(rules_.leaf_size);
    const auto index_of = [&](std::uint64_t i) {
      return (2 * i + 1) * range.count() / (2 * std::uint64_t{sample_count});
    };
    std::array<Entry, k_max_leaf_size> sample;
    for (std::uint32_t i = 0; i < sample_count; ++i) sample[i] = points[index_of(i)];
    std::uint64_t end = range.count();
    for (std::uint32_t i = sample_count; i-- > 0;) {
      std::move_backward(points + index_of(i) + 1, points + end, points + end + (sample_count - 1 - i));
      end = index_of(i);
    }
    std::move_backward(points, points + end, points + end + sample_count);
    std::copy_n(sample.begin(), sample_count, points);
    return range.begin + sample_count;
  }

  void write_leaves(NodeDraft& draft) {
    std::uint32_t next_point = draft.first_point;
    for (int slot = 0; slot < draft.children.count; ++slot) {
      const ChildRange& child = draft.children[slot];
      if (!child.is_leaf) continue;
      draft.boxes[slot] = writer_.write(sorted_.data() + child.points.begin, child.points.count(),
                                        draft.corner, draft.level, next_point);
      next_point += child.points.count();
    }
  }

  /// The nodes that had to wait; they were noted after those below them.
  void finish_top() {
    for (Waiting& waiting : waiting_) {
      NodeDraft& draft = waiting.draft;
      std::uint32_t child = draft.first_child;
      for (int slot = 0; slot < draft.children.count; ++slot)
        if (!draft.children[slot].is_leaf) draft.boxes[slot] = top_boxes_[child++];
      top_[waiting.index] = draft.node(rules_);
      top_boxes_[waiting.index] = draft.box();
    }
    std::vector<Waiting>().swap(waiting_);
  }

  /// Top, then the batches in order, each without its roots, which are in the top.
  void join_nodes() {
    std::vector<std::size_t> begin{top_.size()};
    for (const Batch& batch : batches_)
      begin.push_back(begin.back() + batch.nodes.size() - (batch.end - batch.first));
    arrays_.nodes = HugeArray<Node>(begin.back(), scratch_);
    std::ranges::copy(top_, arrays_.nodes.data());
    in_parallel(batches_.size(), 1, [&](std::size_t b) {
      Batch& batch = batches_[b];
      const std::size_t root_count = batch.end - batch.first;
      for (Node& node : batch.nodes) node.first_child += static_cast<std::uint32_t>(begin[b] - root_count);
      for (std::size_t i = 0; i < root_count; ++i)
        arrays_.nodes[subtrees_[batch.first + i].root] = batch.nodes[i];
      std::copy(batch.nodes.begin() + static_cast<std::ptrdiff_t>(root_count), batch.nodes.end(),
                arrays_.nodes.data() + begin[b]);
      std::vector<Node>().swap(batch.nodes);
    });
  }

  SortedPoints<Entry>& sorted_;
  const SplitRules rules_;
  OctreeArrays& arrays_;
  const ScratchFolder scratch_;
  const LeafWriter writer_;
  const std::size_t subtree_size_;
  const float widening_;
  std::uint32_t next_point_ = 0, exact_begin_;  ///< storage indices
  std::vector<Node> top_;           ///< children are behind their parents; roots of subtrees are kept free
  std::vector<StepBox> top_boxes_;  ///< of the nodes of the top
  std::vector<Waiting> waiting_;
  std::vector<Subtree> subtrees_;
  std::vector<Batch> batches_;
  int level_count_ = 0;
};

}  // namespace alidade
