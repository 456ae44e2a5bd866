// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "octree/octree.h"
#include "octree/query_targets.h"
#include "octree/simd/search.h"
#include "octree/simd/traversal.h"

// How one target is answered. Algorithm 1 answers everything; lanes answer what they are tuned for. Here and
// nowhere else it is chosen. Requires: target and query checked (octree/check_query.h).

namespace alidade {

// Floats of `closest` and `occluded` hold squares of lengths up to here.
constexpr double k_longest = 1e15;

inline bool is_short(const glm::dvec3& v) {
  return std::fabs(v.x) < k_longest && std::fabs(v.y) < k_longest && std::fabs(v.z) < k_longest;
}

/// Lanes take directions to be of length 1 as exactly as make_ray makes them; the contract allows more. Such
/// rays pass check(), too.
inline bool suits_traversal(const Ray& ray) {
  const glm::dvec3& d = ray.direction;
  const double square = d.x * d.x + d.y * d.y + d.z * d.z;
  return std::fabs(square - 1.0) <= 2e-15 && is_short(ray.origin) && !std::isunordered(ray.t_min, ray.t_max);
}

inline bool suits_traversal(const TreeView& tree) {
  return is_short(tree.lattice.offset) && is_short(tree.bounds.min) && is_short(tree.bounds.max) &&
         tree.extent.frame_width < k_longest;
}

inline bool has_traversal(const TreeView& tree, const RayQuery& query) {
  return query.measure != Measure::distance && query.radius < k_longest && suits_traversal(tree);
}

template <class Target>
constexpr bool k_has_search = requires(const TreeView& tree, const Target& target,
                                       const QueryOf<Target>& query) {
  simd::suits_lanes(tree, target, query);
};

/// The lanes that answer this; null if none do.
template <class Target, class Query>
const simd::Search<Target>* lanes_for(const Octree& octree, const Target& target, const Query& query) {
  if constexpr (k_has_search<Target>) {
    if (simd::suits_lanes(octree.view(), target, query))
      return &simd::search<Target>(octree.instruction_set());
  }
  return nullptr;
}

/// Appends the k first answers.
template <class Target, class Query, class Answer>
void find_into(const Octree& octree, const Target& target, const Query& query, std::size_t k,
               std::size_t query_index, std::vector<Answer>& answers) {
  if (const auto* const lanes = lanes_for(octree, target, query))
    return lanes->find(octree.view(), target, query, k, query_index, answers);
  const auto use = [&](const auto& tree, const auto& tree_target) {
    Nearest neighbors(tree_target, k);
    tree_query(tree, tree_target, neighbors);
    const std::vector<Answer> found = neighbors.in_order();
    answers.insert(answers.end(), found.begin(), found.end());
  };
  with_tree_target(octree.view(), target, query, query_index, use, k);
}

/// Whether targets near each other share work.
inline bool suits_turns(const Octree& octree, const PointQuery& query, std::size_t targets) {
  return octree.size() > 0 && query.k <= simd::k_most_in_turn && !query.filter &&
         targets <= std::numeric_limits<std::uint32_t>::max();
}

/// Appends the answers of one target after another, and where those of each end. reach: of simd::Search.
/// Requires: no filter.
inline void find_in_turn(const Octree& octree, std::span<const glm::dvec3> targets, const PointQuery& query,
                         double& reach, std::vector<PointHit>& answers, std::vector<std::size_t>& ends) {
  const auto suits = [&](const glm::dvec3& target) {
    return simd::suits_lanes(octree.view(), target, query);
  };
  while (!targets.empty()) {
    const auto suiting = static_cast<std::size_t>(std::ranges::find_if_not(targets, suits) - targets.begin());
    if (suiting > 0) {
      simd::search<glm::dvec3>(octree.instruction_set())
          .find_in_turn(octree.view(), targets.first(suiting), query, query.k, reach, answers, ends);
    } else {
      find_into(octree, targets[0], query, query.k, 0, answers);
      ends.push_back(answers.size());
    }
    targets = targets.subspan(std::max<std::size_t>(suiting, 1));
  }
}

template <class Target, class Query>
std::size_t count_to(const Octree& octree, const Target& target, const Query& query, std::size_t k,
                     std::size_t query_index) {
  if (const auto* const lanes = lanes_for(octree, target, query))
    return lanes->count(octree.view(), target, query, k, query_index);
  Counter counter(k);
  with_tree_target(octree.view(), target, query, query_index, [&](const auto& tree, const auto& tree_target) {
    tree_query(tree, tree_target, counter);
  });
  return counter.count();
}

template <class Target, class Query>
std::optional<Hit> first_hit(const Octree& octree, const Target& target, const Query& query,
                             std::size_t query_index) {
  if (octree.size() == 0) return std::nullopt;
  if constexpr (std::is_same_v<Target, Ray>) {
    if (has_traversal(octree.view(), query) && suits_traversal(target))
      return simd::traversal(octree.instruction_set()).closest(octree.view(), target, query, query_index);
  }
  std::vector<Hit> hits;
  find_into(octree, target, query, 1, query_index, hits);
  return hits.empty() ? std::nullopt : std::optional(hits.front());
}

template <class Target, class Query>
bool any_hit(const Octree& octree, const Target& target, const Query& query, std::size_t query_index) {
  if (octree.size() == 0) return false;
  if constexpr (std::is_same_v<Target, Ray>) {
    if (has_traversal(octree.view(), query) && suits_traversal(target))
      return simd::traversal(octree.instruction_set()).occluded(octree.view(), target, query, query_index);
  }
  return count_to(octree, target, query, 1, query_index) > 0;
}

}  // namespace alidade
