// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "octree/cloud/point_cloud.h"
#include "octree/query.h"

// What every query means, as plain loops in double over world coordinates: the definition, and the oracle of
// the tests. Same contracts as octree/query.h; cost is linear in the number of points. A cloud has no levels:
// max_level must be left alone (Error); a filter on the level of a point says the same.

namespace alidade::brute_force {

std::optional<Hit> closest(const PointCloud& cloud, const Ray& ray, const RayQuery& query);
std::optional<Hit> closest(const PointCloud& cloud, const Cone& cone, const ConeQuery& query = {});

bool occluded(const PointCloud& cloud, const Ray& ray, const RayQuery& query);
bool occluded(const PointCloud& cloud, const Cone& cone, const ConeQuery& query = {});

std::vector<Hit> find(const PointCloud& cloud, const Ray& ray, const RayQuery& query);
std::vector<Hit> find(const PointCloud& cloud, const Cone& cone, const ConeQuery& query = {});
std::vector<PathHit> find(const PointCloud& cloud, const Path& path, const PathQuery& query);
std::vector<PointHit> find(const PointCloud& cloud, const HalfSpaces& region, const PointQuery& query = {});
std::vector<PointHit> find(const PointCloud& cloud, const Bounds& box, const PointQuery& query = {});
std::vector<PointHit> find(const PointCloud& cloud, const glm::dvec3& point, const PointQuery& query);

std::size_t count(const PointCloud& cloud, const Ray& ray, const RayQuery& query);
std::size_t count(const PointCloud& cloud, const Cone& cone, const ConeQuery& query = {});
std::size_t count(const PointCloud& cloud, const Path& path, const PathQuery& query);
std::size_t count(const PointCloud& cloud, const HalfSpaces& region, const PointQuery& query = {});
std::size_t count(const PointCloud& cloud, const Bounds& box, const PointQuery& query = {});
std::size_t count(const PointCloud& cloud, const glm::dvec3& point, const PointQuery& query);

}  // namespace alidade::brute_force
