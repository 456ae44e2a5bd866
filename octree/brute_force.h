// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "cloud/point_cloud.h"
#include "octree/octree.h"
#include "octree/query.h"

// What every query means, as plain loops in double over world coordinates: the definition, and the oracle of
// the tests. Same contracts as octree/query.h; cost is linear in the number of points. A cloud has no levels:
// max_level is an Error; a filter on the level of a point replaces it. For RayQuery::spacing_factor the
// functions of rays take the spacings of the points, for Measure::crossing their surfaces, too (Errors
// without them).

namespace alidade::brute_force {

/// Distance of each point to its n-th nearest neighbour as octree/spacing.h defines it, by point id.
/// Cost: quadratic.
std::vector<double> spacings(const PointCloud& cloud, int neighbours);

/// What queries of rays may need of the points beside their positions.
struct PointProperties {
  PointProperties() = default;
  PointProperties(const std::vector<double>& by_id, const TreeView* tree = nullptr)
      : spacings(by_id), surfaces(tree) {}

  std::span<const double> spacings{};  ///< by point id
  const TreeView* surfaces = nullptr;  ///< a tree that has them
};

template <LineGeometry T>
std::optional<Hit> closest(const PointCloud& cloud, const T& target,
                           const QueryOf<T>& query = no_conditions<T>(),
                           const PointProperties& properties = {});
template <LineGeometry T>
bool occluded(const PointCloud& cloud, const T& target, const QueryOf<T>& query = no_conditions<T>(),
              const PointProperties& properties = {});
template <TargetGeometry T>
std::vector<AnswerOf<T>> find(const PointCloud& cloud, const T& target,
                              const QueryOf<T>& query = no_conditions<T>(),
                              const PointProperties& properties = {});
template <TargetGeometry T>
std::size_t count(const PointCloud& cloud, const T& target, const QueryOf<T>& query = no_conditions<T>(),
                  const PointProperties& properties = {});

}  // namespace alidade::brute_force
