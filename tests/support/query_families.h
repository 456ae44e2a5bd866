// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "cloud/point_cloud.h"
#include "octree/query.h"
#include "tests/support/random.h"

// Targets of every family with conditions that have broken indices before, around a cloud: k from 1 to all,
// radius from 0 to unlimited, every measure, intervals that hold all, some and nothing, and filters.

namespace alidade::test {

template <class Target, class Query>
struct QueryCase {
  Target target;
  Query query;
  std::string filter = "no filter";  ///< what query.filter asks
};

using FindRayCase = QueryCase<Ray, RayQuery>;
using ConeCase = QueryCase<Cone, ConeQuery>;
using PathCase = QueryCase<Path, PathQuery>;
using RegionCase = QueryCase<HalfSpaces, PointQuery>;
using BoxCase = QueryCase<Bounds, PointQuery>;
using PointCase = QueryCase<glm::dvec3, PointQuery>;

std::vector<FindRayCase> find_ray_cases(const PointCloud& cloud, std::size_t count, Random& random);
std::vector<ConeCase> cone_cases(const PointCloud& cloud, std::size_t count, Random& random);
std::vector<PathCase> path_cases(const PointCloud& cloud, std::size_t count, Random& random);
std::vector<RegionCase> region_cases(const PointCloud& cloud, std::size_t count, Random& random);
std::vector<BoxCase> box_cases(const PointCloud& cloud, std::size_t count, Random& random);
std::vector<PointCase> point_cases(const PointCloud& cloud, std::size_t count, Random& random);

/// All numbers of a case, exactly, so that a failure can be repeated.
std::string describe(const Ray& ray);
std::string describe(const Cone& cone);
std::string describe(const Path& path);
std::string describe(const HalfSpaces& region);
std::string describe(const Bounds& box);
std::string describe(const glm::dvec3& point);
std::string describe(const RayQuery& query);
std::string describe(const ConeQuery& query);
std::string describe(const PathQuery& query);
std::string describe(const PointQuery& query);

template <class Target, class Query>
std::string describe(const QueryCase<Target, Query>& c) {
  return describe(c.target) + ", " + describe(c.query) + ", " + c.filter;
}

}  // namespace alidade::test
