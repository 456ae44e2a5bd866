// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "octree/query_targets.h"
#include "octree/tree_query.h"

namespace alidade::test {

template <class Answer>
struct Explained {
  std::vector<Answer> hits;
  QueryStatistics statistics;
};

/// The answers of `find` by Algorithm 1, and its steps. Requires a target and a query without errors.
template <TargetGeometry T>
Explained<AnswerOf<T>> explain(const Octree& octree, const T& target, const QueryOf<T>& query,
                               const Pruning& pruning = {}) {
  return with_tree_target(octree.view(), target, query, 0, [&](const auto& tree, const auto& tree_target) {
    Nearest neighbors(tree_target, query.k);
    const QueryStatistics statistics = tree_query(tree, tree_target, neighbors, pruning);
    return Explained<AnswerOf<T>>{neighbors.in_order(), statistics};
  });
}

}  // namespace alidade::test
