// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "cloud/point_cloud.h"
#include "octree/query.h"

// What every query means, as plain loops in double over world coordinates: the definition, and the oracle of
// the tests. Same contracts as octree/query.h; cost is linear in the number of points. A cloud has no levels:
// max_level is an Error; a filter on the level of a point replaces it.

namespace alidade::brute_force {

/// Distance of each point to its n-th nearest neighbour as octree/spacing.h defines it, by point id.
/// Cost: quadratic.
std::vector<double> spacings(const PointCloud& cloud, int neighbours);

template <LineGeometry T>
std::optional<Hit> closest(const PointCloud& cloud, const T& target,
                           const QueryOf<T>& query = no_conditions<T>());
template <LineGeometry T>
bool occluded(const PointCloud& cloud, const T& target, const QueryOf<T>& query = no_conditions<T>());
template <TargetGeometry T>
std::vector<AnswerOf<T>> find(const PointCloud& cloud, const T& target,
                              const QueryOf<T>& query = no_conditions<T>());
template <TargetGeometry T>
std::size_t count(const PointCloud& cloud, const T& target, const QueryOf<T>& query = no_conditions<T>());

}  // namespace alidade::brute_force
