// SPDX-License-Identifier: MIT
#include "octree/explain.h"

#include "octree/check_query.h"
#include "octree/query_targets.h"

namespace alidade {
namespace {

template <class Shape, class Query>
auto explain_any(const Octree& octree, const Shape& shape, const Query& query, const Pruning& pruning) {
  check_target(shape, query);
  check_level(octree, query.max_level);
  if constexpr (std::is_same_v<Query, RayQuery>) check_spacings(octree, query);
  return with_tree_target(octree.view(), shape, query, 0, [&](const auto& tree, const auto& target) {
    Nearest neighbors(target, query.k);
    const QueryStatistics statistics = tree_query(tree, target, neighbors, pruning);
    return Explained<typename decltype(neighbors)::Answer>{neighbors.in_order(), statistics};
  });
}

}  // namespace

Explained<Hit> explain(const Octree& octree, const Ray& ray, const RayQuery& query, const Pruning& pruning) {
  return explain_any(octree, ray, query, pruning);
}

Explained<Hit> explain(const Octree& octree, const Cone& cone, const ConeQuery& query,
                       const Pruning& pruning) {
  return explain_any(octree, cone, query, pruning);
}

Explained<PathHit> explain(const Octree& octree, const Path& path, const PathQuery& query,
                           const Pruning& pruning) {
  return explain_any(octree, path, query, pruning);
}

Explained<PointHit> explain(const Octree& octree, const HalfSpaces& region, const PointQuery& query,
                            const Pruning& pruning) {
  return explain_any(octree, region, query, pruning);
}

Explained<PointHit> explain(const Octree& octree, const Bounds& box, const PointQuery& query,
                            const Pruning& pruning) {
  return explain_any(octree, box, query, pruning);
}

Explained<PointHit> explain(const Octree& octree, const glm::dvec3& point, const PointQuery& query,
                            const Pruning& pruning) {
  return explain_any(octree, point, query, pruning);
}

}  // namespace alidade
