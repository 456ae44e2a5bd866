// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_NEAREST_FIRST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_NEAREST_FIRST_INL_H
#undef ALIDADE_SIMD_NEAREST_FIRST_INL_H
#else
#define ALIDADE_SIMD_NEAREST_FIRST_INL_H
#endif

#include "octree/simd/box_test-inl.h"
#include "octree/simd/collectors-inl.h"
#include "octree/simd/first_answers.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// What lanes find out about the children of a node.
struct TestedBoxes {
  unsigned met = 0;     ///< bit per slot: may hold points that count; of empty slots anything
  unsigned inside = 0;  ///< of these, those all of whose points count (used only for counting)
  alignas(64) float bound[k_node_width];  ///< no point below is earlier, in the kernel's own measure
};

/// Algorithm 1 of the paper (octree/tree_query.h) with lanes: all children of a node at once, the nearest
/// first.
///
/// A *kernel* measures the target:
/// - at(corner, level) -> Local: the target as seen from a frame's corner, where numbers are small;
/// - limit(cut): the bound above which nothing counts any more;
/// - test_boxes(local, node, level, cut, boxes), test_points(local, leaf, count, level, cut, points).
template <class Kernel, class Collector>
class NearestFirst {
 public:
  /// k: of points at one position only the first k are examined; k_all examines all.
  NearestFirst(const TreeView& tree, const Kernel& kernel, Collector& collector, int max_level, std::size_t k)
      : tree_(tree), kernel_(kernel), collector_(collector), max_level_(max_level), k_(k) {}

  void run() {
    stack_[0] = {-std::numeric_limits<float>::infinity(), root_frame(tree_)};
    stack_count_ = 1;
    while (stack_count_ > 0 && !collector_.is_done()) {
      const OpenNode open = stack_[--stack_count_];
      if (open.bound <= limit()) visit(open.frame);
    }
  }

 private:
  struct OpenNode {
    float bound;
    Frame frame;
  };
  static constexpr int k_stack_size = k_max_tree_depth * (k_node_width - 1) + 1;

  float limit() const { return kernel_.limit(collector_.cut()); }

  void visit(const Frame& frame) {
    const Node& node = tree_.nodes[frame.node];
    const typename Kernel::Local local = kernel_.at(frame.corner, frame.level);
    TestedBoxes boxes;
    kernel_.template test_boxes<Collector::k_counts>(local, node, frame.level, collector_.cut(), boxes);
    const Slots slots(node);
    unsigned met = boxes.met & (frame.depth < max_level_ ? slots.leaf | slots.inner : slots.leaf);
    if (frame.level == k_min_frame_level && k_ != k_all) met &= ~slots_after_k_equal(tree_, frame, k_);
    if constexpr (Collector::k_counts) {
      for (unsigned inside = met & boxes.inside; inside != 0; inside &= inside - 1)
        collector_.add(subtree_count(tree_, frame, std::countr_zero(inside)));
      met &= ~boxes.inside;
    }
    visit_leaves(frame, local, node, slots, met & slots.leaf, boxes);
    push_children(frame, node, slots, met & slots.inner, boxes);
  }

  void visit_leaves(const Frame& frame, const typename Kernel::Local& local, const Node& node,
                    const Slots& slots, unsigned leaves, const TestedBoxes& boxes) {
    int order[k_node_width], count = 0;
    for (; leaves != 0; leaves &= leaves - 1) {
      const int slot = std::countr_zero(leaves);
      int at = count++;
      if constexpr (Collector::k_has_cut)
        for (; at > 0 && boxes.bound[order[at - 1]] > boxes.bound[slot]; --at) order[at] = order[at - 1];
      order[at] = slot;
    }
    TestedPoints points;
    for (int i = 0; i < count; ++i) {
      const int slot = order[i];
      if (Collector::k_has_cut && boxes.bound[slot] > limit()) return;
      const Leaf leaf = slots.leaf_in(node, frame, slot);
      kernel_.test_points(local, leaf, frame.level, collector_.cut(), points);
      if (points.possible == 0) continue;
      collector_.add(leaf, points);
      if (collector_.is_done()) return;
    }
  }

  /// Farthest first on the stack, so that the nearest is visited next.
  void push_children(const Frame& frame, const Node& node, const Slots& slots, unsigned children,
                     const TestedBoxes& boxes) {
    const float limit_now = limit();
    const int bottom = stack_count_;
    for (; children != 0; children &= children - 1) {
      const int slot = std::countr_zero(children);
      if (boxes.bound[slot] > limit_now) continue;
      const OpenNode child{boxes.bound[slot], slots.child_in(node, frame, slot)};
      int at = stack_count_++;
      if constexpr (Collector::k_has_cut)
        for (; at > bottom && stack_[at - 1].bound < child.bound; --at) stack_[at] = stack_[at - 1];
      stack_[at] = child;
    }
  }

  const TreeView& tree_;
  const Kernel& kernel_;
  Collector& collector_;
  const int max_level_;
  const std::size_t k_;
  int stack_count_ = 0;
  OpenNode stack_[k_stack_size];
};

template <class Query>
bool knows_all_points(const Query& query) {
  return !query.filter && query.max_level == k_all_levels;
}

/// Appends the k first answers. measure_shift, shift_error: as NearestCollector takes them.
template <class Kernel, class Target, class Query, class Answer>
void find_first(const TreeView& tree, const Kernel& kernel, const Target& target, const Query& query,
                std::size_t k, double measure_shift, double shift_error, std::vector<Answer>& answers) {
  NearestCollector<Target> nearest(tree, target, k, measure_shift, shift_error, answers);
  NearestFirst(tree, kernel, nearest, query.max_level, knows_all_points(query) ? k : k_all).run();
  nearest.finish();
}

/// How many answers, up to k.
template <class Kernel, class Target, class Query>
std::size_t count_first(const TreeView& tree, const Kernel& kernel, const Target& target, const Query& query,
                        std::size_t k) {
  CountCollector<Target> counter(tree, target, k);
  NearestFirst(tree, kernel, counter, query.max_level, k_all).run();
  return counter.count();
}

/// Appends all answers.
template <class Kernel, class Target, class Query, class Answer>
void find_all(const TreeView& tree, const Kernel& kernel, const Target& target, const Query& query,
              std::vector<Answer>& answers) {
  const auto count = [&] {
    return knows_all_points(query) ? count_first(tree, kernel, target, query, k_all) : 0;
  };
  AllCollector all(tree, target, count, answers);
  NearestFirst(tree, kernel, all, query.max_level, k_all).run();
  all.finish();
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
