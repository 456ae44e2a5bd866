// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "octree/cloud/point_cloud.h"
#include "octree/query.h"

// What every query means, as plain loops in double over world coordinates: the definition, and the oracle of
// the tests. Same contracts as octree/query.h; cost is linear in the number of points.

namespace alidade::brute_force {

std::optional<Hit> closest(const PointCloud& cloud, const Ray& ray, const RayQuery& query);
bool occluded(const PointCloud& cloud, const Ray& ray, const RayQuery& query);

}  // namespace alidade::brute_force
