// SPDX-License-Identifier: MIT
#include "octree/explain.h"

#include "octree/check_query.h"
#include "octree/query_targets.h"

namespace alidade {

template <TargetGeometry T>
Explained<AnswerOf<T>> explain(const Octree& octree, const T& target, const QueryOf<T>& query,
                               const Pruning& pruning) {
  check_target(octree, target, query);
  return with_tree_target(octree.view(), target, query, 0, [&](const auto& tree, const auto& tree_target) {
    Nearest neighbors(tree_target, query.k);
    const QueryStatistics statistics = tree_query(tree, tree_target, neighbors, pruning);
    return Explained<AnswerOf<T>>{neighbors.in_order(), statistics};
  });
}

template Explained<Hit> explain(const Octree&, const Ray&, const RayQuery&, const Pruning&);
template Explained<Hit> explain(const Octree&, const Cone&, const ConeQuery&, const Pruning&);
template Explained<PathHit> explain(const Octree&, const Path&, const PathQuery&, const Pruning&);
template Explained<PointHit> explain(const Octree&, const HalfSpaces&, const PointQuery&, const Pruning&);
template Explained<PointHit> explain(const Octree&, const Bounds&, const PointQuery&, const Pruning&);
template Explained<PointHit> explain(const Octree&, const glm::dvec3&, const PointQuery&, const Pruning&);

}  // namespace alidade
