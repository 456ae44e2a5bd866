// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "octree/copc/copc_tree.h"
#include "octree/query_batch.h"
#include "octree/query_targets.h"
#include "octree/tree_query.h"
#include "tools/query/ask.h"

namespace alidade {

/// Asks a COPC file where it lies, as Asker asks an octree: by Algorithm 1 over the file's own hierarchy. Has
/// the same functions, and the same answers.
template <class Target>
class CopcAsker {
 public:
  using Query = typename Family<Target>::Query;
  using Answer = typename Family<Target>::Answer;

  /// The cache must outlive this object.
  CopcAsker(const CopcCache& cache, Query query) : cache_(cache), query_(std::move(query)) {}

  std::size_t k() const { return query_.k; }

  Answers<Answer> find(std::span<const Target> targets, std::size_t most) {
    Query query = query_;
    query.k = std::min(query.k, most);
    return answer_all<Answer>(targets, k_grain, [&](std::size_t i, std::vector<Answer>& answers) {
      const auto asked = make_target(targets[i], query, i);
      Nearest neighbors(asked, query.k);
      walk(asked, neighbors);
      const std::vector<Answer> found = neighbors.in_order();
      answers.insert(answers.end(), found.begin(), found.end());
    });
  }

  std::vector<std::size_t> count(std::span<const Target> targets, bool any_is_enough) {
    Query query = query_;
    if (any_is_enough) query.k = 1;
    std::vector<std::size_t> counts(targets.size());
    for_each_range(targets, k_grain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        Counter counter(query.k);
        walk(make_target(targets[i], query, i), counter);
        counts[i] = counter.count();
      }
    });
    return counts;
  }

  QueryStatistics statistics() const {
    QueryStatistics sum;
    for (const QueryStatistics& part : statistics_) sum += part;
    return sum;
  }

 private:
  static constexpr std::size_t k_grain = 4;

  template <class Asked, class Neighbors>
  void walk(const Asked& asked, Neighbors& neighbors) {
    const QueryStatistics statistics = tree_query(CopcTree(cache_), asked, neighbors);
    statistics_.local() += statistics;
  }

  const CopcCache& cache_;
  Query query_;
  tbb::enumerable_thread_specific<QueryStatistics> statistics_;
};

}  // namespace alidade
