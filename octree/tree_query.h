// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/bounds.h"
#include "base/interval.h"

// Algorithm 1 of the paper (Teuscher et al. 2026, section 3), once for every tree and every target.
//
//   OctreeTree tree(octree.view());
//   RayTarget target(ray, query);
//   Nearest<RayTarget> neighbors(target, 8);
//   const QueryStatistics statistics = tree_query(tree, target, neighbors);
//   for (const Hit& hit : neighbors.in_order()) use(hit);
//
// A *tree* is anything that shows bounds, points and children of a node. Nodes are values that the tree hands
// out and takes back. To plug in another index, write a small struct with these members:
// - R-tree: Node = pointer to a page; bounds as stored; children of inner pages; points of leaf pages.
// - kd-tree: Node = range of the array and its box, halved at the split when children are requested; points
//   of ranges that are not split any more (or the one at the median).
// - COPC, an octree on disk: Node = key of the hierarchy; bounds = its cell; points = those of its chunk,
//   read when requested; children = the keys that exist. Inner nodes hold points, too, which is fine.
// Bounds must hold all points at and below the node; they need not be tight. `point_id` is what answers and
// ties are distinguished by.
//
// A *target* is anything with a distance to a point and bounds on it for a box: octree/query_targets.h.

namespace alidade {

template <class T>
concept SpatialTree = requires(const T& tree, const typename T::Node& node,
                               bool (*point)(std::uint64_t point_id, const glm::dvec3& position),
                               void (*child)(const typename T::Node&)) {
  { tree.empty() } -> std::convertible_to<bool>;
  { tree.root() } -> std::convertible_to<typename T::Node>;  // of a tree that is not empty
  { tree.bounds(node) } -> std::convertible_to<Bounds>;
  tree.for_each_point(node, point);  // of the node itself; stops when the callee returns false
  tree.for_each_child(node, child);
};

/// What holds for all points in a box.
struct Reach {
  double distance = 0.0;  ///< none is nearer to the target
  Interval t;             ///< none projects elsewhere
};

/// What bounds the distance of a box from below.
enum class DistanceBound {
  none,
  sphere,  ///< eq. 3, of rays and cones; other targets take `box`
  box,     ///< the formula of the distance on intervals (base/interval.h): tighter, and as cheap
};

/// The pruning mechanisms of section 3.3; each can be switched off to see what it gains. Answers stay the
/// same.
struct Pruning {
  DistanceBound distance = DistanceBound::box;  ///< ray minimum distance
  bool time_interval = true;                    ///< projected time interval
  bool dynamic_k = true;                        ///< dynamic k distance filter
};

template <class T>
concept QueryTarget = requires(const T& target, const Bounds& box, const Reach& reach, DistanceBound bound,
                               const glm::dvec3& position, std::uint64_t point_id,
                               const typename T::Answer& answer) {
  /// The point as an answer if it meets all conditions. Decides exactly; all that follows only discards.
  { target.evaluate(position, point_id) } -> std::same_as<std::optional<typename T::Answer>>;
  /// Whether answer a is before answer b.
  { target.precedes(answer, answer) } -> std::same_as<bool>;
  /// The value answers are ordered by before their ids.
  { target.measured(answer) } -> std::same_as<double>;
  { target.reach(box, bound) } -> std::same_as<Reach>;
  /// d_node > r: no point can be near enough.
  { target.too_far(reach) } -> std::same_as<bool>;
  /// t_near > t_max or t_far < t_min.
  { target.outside_interval(reach) } -> std::same_as<bool>;
  /// No point's measure is smaller.
  { target.least_measure(reach) } -> std::same_as<double>;
};

/// How much work a query was.
struct QueryStatistics {
  std::uint64_t nodes_visited = 0;   ///< whose points and children were examined
  std::uint64_t leaves_visited = 0;  ///< those of them with points
  std::uint64_t points_tested = 0;
  std::uint64_t pruned_by_distance = 0;  ///< nodes, with all below them
  std::uint64_t pruned_by_interval = 0;
  std::uint64_t pruned_by_k = 0;

  QueryStatistics& operator+=(const QueryStatistics& other) {
    nodes_visited += other.nodes_visited;
    leaves_visited += other.leaves_visited;
    points_tested += other.points_tested;
    pruned_by_distance += other.pruned_by_distance;
    pruned_by_interval += other.pruned_by_interval;
    pruned_by_k += other.pruned_by_k;
    return *this;
  }
  bool operator==(const QueryStatistics&) const = default;
};

/// N of Algorithm 1: the k first answers found so far. Kept as a heap, whose top is the last of them.
template <QueryTarget Target>
class Nearest {
 public:
  using Answer = typename Target::Answer;

  Nearest(const Target& target, std::size_t k) : target_(target), k_(k) {}

  /// Whether the query must continue.
  bool insert(const Answer& answer) {
    const auto before = order();
    if (answers_.size() < k_) {
      answers_.push_back(answer);
      if (k_ != std::numeric_limits<std::size_t>::max())
        std::push_heap(answers_.begin(), answers_.end(), before);
    } else if (before(answer, answers_.front())) {
      std::pop_heap(answers_.begin(), answers_.end(), before);
      answers_.back() = answer;
      std::push_heap(answers_.begin(), answers_.end(), before);
    }
    return true;
  }

  /// Above this measure nothing can become one of the k first any more.
  double limit() const {
    return answers_.size() < k_ ? std::numeric_limits<double>::infinity()
                                : target_.measured(answers_.front());
  }

  /// Gives the answers away, first to last.
  std::vector<Answer> in_order() {
    std::sort(answers_.begin(), answers_.end(), order());
    return std::move(answers_);
  }

 private:
  auto order() const {
    return [this](const Answer& a, const Answer& b) { return target_.precedes(a, b); };
  }

  const Target& target_;
  std::size_t k_;
  std::vector<Answer> answers_;
};

/// Instead of Nearest: only how many, up to k. With k = 1: whether any.
class Counter {
 public:
  explicit Counter(std::size_t k) : k_(k) {}

  template <class Answer>
  bool insert(const Answer&) {
    return ++count_ < k_;
  }
  double limit() const { return std::numeric_limits<double>::infinity(); }
  std::size_t count() const { return count_; }

 private:
  std::size_t k_;
  std::size_t count_ = 0;
};

/// Algorithm 1. The paper's steps are named on the right; k, r and the interval are held by `neighbors` and
/// `target`. Nodes are tested when they become candidates rather than when they are popped, because the
/// nearest child goes first (the order of C is free in the paper); k's limit is compared again then.
template <SpatialTree Tree, QueryTarget Target, class Neighbors>
QueryStatistics tree_query(const Tree& tree, const Target& target, Neighbors& neighbors,
                           const Pruning& pruning = {}) {
  struct CandidateNode {
    double least_measure;
    typename Tree::Node node;
  };
  QueryStatistics statistics;
  if (tree.empty()) return statistics;

  std::vector<CandidateNode> candidates;  // C
  const auto add_candidate = [&](const typename Tree::Node& node) {
    const Reach reach = target.reach(tree.bounds(node), pruning.distance);   // d_node, [t_near, t_far]
    if (pruning.distance != DistanceBound::none && target.too_far(reach)) {  // d_node > r
      ++statistics.pruned_by_distance;
      return;
    }
    if (pruning.time_interval && target.outside_interval(reach)) {  // t_near > t_max or t_far < t_min
      ++statistics.pruned_by_interval;
      return;
    }
    double least_measure = target.least_measure(reach);
    if (std::isnan(least_measure)) least_measure = -std::numeric_limits<double>::infinity();
    if (pruning.dynamic_k && least_measure > neighbors.limit()) {  // r or t_max as updated from N
      ++statistics.pruned_by_k;
      return;
    }
    candidates.push_back({least_measure, node});
  };

  add_candidate(tree.root());  // C <- [root]
  bool go_on = true;
  while (!candidates.empty() && go_on) {                // while C is not empty
    const CandidateNode candidate = candidates.back();  // pop first element of C
    candidates.pop_back();
    if (pruning.dynamic_k && candidate.least_measure > neighbors.limit()) {
      ++statistics.pruned_by_k;
      continue;
    }
    ++statistics.nodes_visited;

    const std::uint64_t tested_before = statistics.points_tested;
    tree.for_each_point(candidate.node, [&](std::uint64_t point_id, const glm::dvec3& position) {
      ++statistics.points_tested;
      const auto answer = target.evaluate(position, point_id);  // d_point > r, t_p < t_min, t_p > t_max
      if (answer) go_on = neighbors.insert(*answer);            // insert p into N (1); update r or t_max (2)
      return go_on;
    });
    if (statistics.points_tested != tested_before) ++statistics.leaves_visited;
    if (!go_on) break;

    const std::size_t first_child = candidates.size();
    tree.for_each_child(candidate.node, add_candidate);  // add children to C
    std::sort(
        candidates.begin() + static_cast<std::ptrdiff_t>(first_child), candidates.end(),
        [](const CandidateNode& a, const CandidateNode& b) { return a.least_measure > b.least_measure; });
  }
  return statistics;
}

}  // namespace alidade
