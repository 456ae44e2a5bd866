// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <span>
#include <vector>

#include "octree/check_query.h"
#include "octree/query_targets.h"
#include "octree/tree_query.h"
#include "tools/query/query_family.h"

namespace alidade {

/// Asks any tree many targets by Algorithm 1, in parallel, and counts its steps.
template <class Target>
class TreeAsker {
 public:
  using Query = typename Family<Target>::Query;
  using Answer = typename Family<Target>::Answer;

  /// As find() of octree/query.h.
  template <SpatialTree Tree>
  Answers<Answer> find(const Tree& tree, std::span<const Target> targets, const Query& query) {
    return answer_all<Answer>(targets, k_grain, [&](std::size_t i, std::vector<Answer>& answers) {
      const auto asked = make_target(targets[i], query, i);
      Nearest neighbors(asked, query.k);
      statistics_.local() += tree_query(tree, asked, neighbors);
      const std::vector<Answer> found = neighbors.in_order();
      answers.insert(answers.end(), found.begin(), found.end());
    });
  }

  /// As count() of octree/query.h.
  template <SpatialTree Tree>
  std::vector<std::size_t> count(const Tree& tree, std::span<const Target> targets, const Query& query) {
    std::vector<std::size_t> counts(targets.size());
    for_each_range(targets, k_grain, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        Counter counter(query.k);
        statistics_.local() += tree_query(tree, make_target(targets[i], query, i), counter);
        counts[i] = counter.count();
      }
    });
    return counts;
  }

  /// All work so far.
  QueryStatistics statistics() const {
    QueryStatistics sum;
    for (const QueryStatistics& part : statistics_) sum += part;
    return sum;
  }

 private:
  static constexpr std::size_t k_grain = 4;

  tbb::enumerable_thread_specific<QueryStatistics> statistics_;
};

}  // namespace alidade
