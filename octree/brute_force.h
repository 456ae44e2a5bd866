// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "cloud/point_cloud.h"
#include "octree/query.h"

// What every query means, as plain loops in double over world coordinates: the definition, and the oracle of
// the tests. Same contracts as octree/query.h; cost is linear in the number of points. A cloud has no levels:
// max_level must be left alone (Error); a filter on the level of a point says the same. For
// RayQuery::spacing_factor the functions of rays take the spacings of the points (Error without them).

namespace alidade::brute_force {

/// Distance of each point to its n-th nearest neighbour as octree/spacing.h defines it, by point id.
/// Cost: quadratic.
std::vector<double> spacings(const PointCloud& cloud, int neighbours);

std::optional<Hit> closest(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
                           std::span<const double> spacings = {});
std::optional<Hit> closest(const PointCloud& cloud, const Cone& cone, const ConeQuery& query = {});

bool occluded(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
              std::span<const double> spacings = {});
bool occluded(const PointCloud& cloud, const Cone& cone, const ConeQuery& query = {});

std::vector<Hit> find(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
                      std::span<const double> spacings = {});
std::vector<Hit> find(const PointCloud& cloud, const Cone& cone, const ConeQuery& query = {});
std::vector<PathHit> find(const PointCloud& cloud, const Path& path, const PathQuery& query);
std::vector<PointHit> find(const PointCloud& cloud, const HalfSpaces& region, const PointQuery& query = {});
std::vector<PointHit> find(const PointCloud& cloud, const Bounds& box, const PointQuery& query = {});
std::vector<PointHit> find(const PointCloud& cloud, const glm::dvec3& point, const PointQuery& query);

std::size_t count(const PointCloud& cloud, const Ray& ray, const RayQuery& query,
                  std::span<const double> spacings = {});
std::size_t count(const PointCloud& cloud, const Cone& cone, const ConeQuery& query = {});
std::size_t count(const PointCloud& cloud, const Path& path, const PathQuery& query);
std::size_t count(const PointCloud& cloud, const HalfSpaces& region, const PointQuery& query = {});
std::size_t count(const PointCloud& cloud, const Bounds& box, const PointQuery& query = {});
std::size_t count(const PointCloud& cloud, const glm::dvec3& point, const PointQuery& query);

}  // namespace alidade::brute_force
