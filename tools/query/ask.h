// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "octree/octree.h"
#include "octree/query.h"
#include "octree/query_targets.h"
#include "tools/query/tree_asker.h"

namespace alidade {

/// Asks one octree many batches of targets: by the functions of octree/query.h, or, if work is to be
/// explained, by Algorithm 1 with its steps counted. Answers are the same.
template <class Target>
class Asker {
 public:
  using Query = typename Family<Target>::Query;
  using Answer = typename Family<Target>::Answer;

  /// The octree must outlive this object.
  Asker(const Octree& octree, Query query, bool is_explained)
      : octree_(octree), query_(std::move(query)), is_explained_(is_explained) {}

  std::size_t k() const { return query_.k; }

  /// The first `most` of the answers that the query asks for, for each target.
  Answers<Answer> find(std::span<const Target> targets, std::size_t most) {
    Query query = query_;
    query.k = std::min(query.k, most);
    if (is_explained_) return explaining_.find(tree(), targets, query);
    if constexpr (std::is_same_v<Target, Ray>) {
      if (query.k == 1) return closest_of(targets, query);
    }
    return alidade::find(octree_, targets, query);
  }

  /// How many answers each target has; with `any_is_enough` 0 or 1.
  std::vector<std::size_t> count(std::span<const Target> targets, bool any_is_enough) {
    Query query = query_;
    if (any_is_enough) query.k = 1;
    std::vector<std::size_t> counts(targets.size());
    if (is_explained_) return explaining_.count(tree(), targets, query);
    if constexpr (std::is_same_v<Target, Ray>) {
      if (any_is_enough) {
        std::vector<std::uint8_t> answers(targets.size());
        occluded(octree_, targets, query, answers);
        std::copy(answers.begin(), answers.end(), counts.begin());
        return counts;
      }
    }
    alidade::count(octree_, targets, query, counts);
    return counts;
  }

  /// All work so far; only if it is explained.
  QueryStatistics statistics() const { return explaining_.statistics(); }

 private:
  OctreeTree tree() const { return OctreeTree(octree_.view(), query_.max_level); }

  Answers<Answer> closest_of(std::span<const Ray> rays, const RayQuery& query) {
    std::vector<std::optional<Hit>> hits(rays.size());
    closest(octree_, rays, query, hits);
    Answers<Hit> answers;
    for (const std::optional<Hit>& hit : hits) {
      if (hit) answers.all.push_back(*hit);
      answers.begin.push_back(answers.all.size());
    }
    return answers;
  }

  const Octree& octree_;
  Query query_;
  bool is_explained_;
  TreeAsker<Target> explaining_;
};

}  // namespace alidade
