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
Explained<Hit> explain(const Octree& octree, const Ray& ray, const RayQuery& query,
                       const Pruning& pruning = {});
Explained<Hit> explain(const Octree& octree, const Cone& cone, const ConeQuery& query,
                       const Pruning& pruning = {});
Explained<PathHit> explain(const Octree& octree, const Path& path, const PathQuery& query,
                           const Pruning& pruning = {});
Explained<PointHit> explain(const Octree& octree, const HalfSpaces& region, const PointQuery& query,
                            const Pruning& pruning = {});
Explained<PointHit> explain(const Octree& octree, const Bounds& box, const PointQuery& query,
                            const Pruning& pruning = {});
Explained<PointHit> explain(const Octree& octree, const glm::dvec3& point, const PointQuery& query,
                            const Pruning& pruning = {});

}  // namespace alidade
