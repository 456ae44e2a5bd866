// SPDX-License-Identifier: MIT
#include "octree/brute_force.h"

#include "octree/candidate.h"

namespace alidade::brute_force {

std::optional<Hit> closest(const PointCloud& cloud, const Ray& ray, const RayQuery& query) {
  check(query);
  std::optional<Hit> best;
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    const std::optional<Hit> hit = evaluate(ray, query, cloud.world(id), id);
    if (hit && (!best || precedes(query.measure, *hit, *best))) best = hit;
  }
  return best;
}

bool occluded(const PointCloud& cloud, const Ray& ray, const RayQuery& query) {
  check(query);
  for (std::size_t id = 0; id < cloud.size(); ++id) {
    if (evaluate(ray, query, cloud.world(id), id)) return true;
  }
  return false;
}

}  // namespace alidade::brute_force
