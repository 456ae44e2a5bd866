// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "octree/query.h"
#include "octree/tree_query.h"

// What a query costs and what saves work: the same answers as `find`, by Algorithm 1 (octree/tree_query.h),
// whose steps are counted. The tuned traversals behind `find` discard earlier and count nothing.
//
//   const Explained<Hit> all = explain(octree, ray, query);
//   const Explained<Hit> loose = explain(octree, ray, query, {.distance = DistanceBound::sphere});
//   // all.hits == loose.hits; all.statistics.nodes_visited <= loose.statistics.nodes_visited

namespace alidade {

template <class Answer>
struct Explained {
  std::vector<Answer> hits;
  QueryStatistics statistics;
};

/// Contracts and Errors: as `find`. Cost: as `find` without lanes.
template <TargetGeometry T>
Explained<AnswerOf<T>> explain(const Octree& octree, const T& target, const QueryOf<T>& query,
                               const Pruning& pruning = {});

}  // namespace alidade
