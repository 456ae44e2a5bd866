// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "octree/octree.h"
#include "octree/octree_tree.h"
#include "octree/query.h"
#include "octree/query_batch.h"
#include "octree/query_targets.h"
#include "octree/tree_query.h"

namespace alidade {

/// Types of a family of queries.
template <class Target>
struct Family {
  using Query = PointQuery;
  using Answer = PointHit;
};
template <>
struct Family<Ray> {
  using Query = RayQuery;
  using Answer = Hit;
};
template <>
struct Family<Cone> {
  using Query = ConeQuery;
  using Answer = Hit;
};
template <>
struct Family<Path> {
  using Query = PathQuery;
  using Answer = PathHit;
};

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
    if (is_explained_) return explained_find(targets, query);
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
    if (is_explained_) {
      for_each_range(targets, k_grain, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
          Counter counter(query.k);
          walk(make_target(targets[i], query, i), query, counter);
          counts[i] = counter.count();
        }
      });
      return counts;
    }
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
  QueryStatistics statistics() const {
    QueryStatistics sum;
    for (const QueryStatistics& part : statistics_) sum += part;
    return sum;
  }

 private:
  static constexpr std::size_t k_grain = 4;

  template <class Asked, class Neighbors>
  void walk(const Asked& asked, const Query& query, Neighbors& neighbors) {
    statistics_.local() += tree_query(OctreeTree(octree_.view(), query.max_level), asked, neighbors);
  }

  Answers<Answer> explained_find(std::span<const Target> targets, const Query& query) {
    return answer_all<Answer>(targets, k_grain, [&](std::size_t i, std::vector<Answer>& answers) {
      const auto asked = make_target(targets[i], query, i);
      Nearest neighbors(asked, query.k);
      walk(asked, query, neighbors);
      const std::vector<Answer> found = neighbors.in_order();
      answers.insert(answers.end(), found.begin(), found.end());
    });
  }

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
  tbb::enumerable_thread_specific<QueryStatistics> statistics_;
};

}  // namespace alidade
