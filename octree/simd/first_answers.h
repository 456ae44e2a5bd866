// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "octree/tree_walk.h"

// How many points are below a node, without visiting them: from frames of level k_exact_frame_level on, all
// points below a node are contiguous, first those of its leaves, then those of its inner children in slot
// order.

namespace alidade::simd {

/// Past the last storage index below a node whose frame's level is at most k_exact_frame_level.
inline std::uint32_t end_index(const TreeView& tree, std::uint32_t node_index) {
  for (;;) {
    const Node& node = tree.nodes[node_index];
    const auto inner = static_cast<std::uint32_t>(std::popcount(inner_slots(node)));
    if (inner == 0) return node.first_point + leaf_counts(node).sum();
    node_index = node.first_child + inner - 1;
  }
}

/// Points of a child and all below it.
inline std::uint32_t subtree_count(const TreeView& tree, const Frame& parent, int slot) {
  const Node& node = tree.nodes[parent.node];
  if (is_leaf(node.kind[slot])) return node.kind[slot];
  const Frame child = child_frame(tree, parent, slot);
  if (child.level <= k_exact_frame_level)
    return end_index(tree, child.node) - tree.nodes[child.node].first_point;
  std::uint32_t count = 0;
  for (int below = 0; below < k_node_width; ++below)
    if (tree.nodes[child.node].kind[below] != 0) count += subtree_count(tree, child, below);
  return count;
}

/// Which slots of a node need not be visited for the k first points: boxes are exact at the lowest level, so
/// slots with equal boxes of one lattice position hold points that differ by their ids only, the lowest ids
/// in the first of them (Node in octree/octree.h). Once k points are in the slots before, the rest cannot
/// count. Keeps queries among a million equal points from testing each. Requires a frame of level
/// k_min_frame_level.
inline unsigned slots_after_k_equal(const TreeView& tree, const Frame& frame, std::size_t k) {
  const Node& node = tree.nodes[frame.node];
  const auto is_one_position = [&](int slot) {
    return node.kind[slot] != 0 && node.low[0][slot] == node.high[0][slot] &&
           node.low[1][slot] == node.high[1][slot] && node.low[2][slot] == node.high[2][slot];
  };
  const auto equal = [&](int a, int b) {
    return node.low[0][a] == node.low[0][b] && node.low[1][a] == node.low[1][b] &&
           node.low[2][a] == node.low[2][b];
  };
  unsigned surplus = 0;
  // Children are in Morton order, so equal ones are adjacent.
  std::size_t before = 0;
  for (int slot = 1; slot < k_node_width; ++slot) {
    if (!is_one_position(slot) || !is_one_position(slot - 1) || !equal(slot, slot - 1)) {
      before = 0;
      continue;
    }
    if (before < k) before += subtree_count(tree, frame, slot - 1);
    if (before >= k) surplus |= 1u << slot;
  }
  return surplus;
}

/// Order of a target's answers (octree/query_targets.h), as the standard algorithms take it.
template <class Target>
struct Precedes {
  const Target& target;
  bool operator()(const typename Target::Answer& a, const typename Target::Answer& b) const {
    return target.precedes(a, b);
  }
};

/// The k first of the answers given to it, behind those that a list already has. Some more than k are kept,
/// so that the list is rarely gone through.
template <class Target>
class FirstAnswers {
 public:
  using Answer = typename Target::Answer;

  FirstAnswers(const Target& target, std::size_t k, std::vector<Answer>& answers)
      : target_(target), k_(k), answers_(answers), first_(answers.size()) {
    constexpr std::size_t k_most_at_once = 256;
    const std::size_t room = first_ + std::min(k, k_most_at_once) + k_few;
    if (answers.capacity() < room) answers.reserve(std::max(2 * answers.capacity(), room));
  }

  void insert(const Answer& answer) {
    answers_.push_back(answer);
    if (answers_.size() - first_ < 2 * k_ + k_few) return;
    std::nth_element(begin(), begin() + static_cast<std::ptrdiff_t>(k_ - 1), answers_.end(),
                     Precedes<Target>{target_});
    answers_.resize(first_ + k_);
    limit_ = target_.measured(answers_.back());
  }

  /// No answer of a greater measure is one of the k first.
  double limit() const { return limit_; }

  /// Puts them in order.
  void finish() {
    std::sort(begin(), answers_.end(), Precedes<Target>{target_});
    if (answers_.size() - first_ > k_) answers_.resize(first_ + k_);
  }

 private:
  static constexpr std::size_t k_few = 16;

  auto begin() { return answers_.begin() + static_cast<std::ptrdiff_t>(first_); }

  const Target& target_;
  const std::size_t k_;
  std::vector<Answer>& answers_;
  const std::size_t first_;
  double limit_ = std::numeric_limits<double>::infinity();
};

}  // namespace alidade::simd
