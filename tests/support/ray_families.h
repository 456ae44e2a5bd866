// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "cloud/point_cloud.h"
#include "octree/query.h"
#include "tests/support/random.h"

namespace alidade::test {

/// A ray with the conditions of its query.
struct RayCase {
  Ray ray;
  RayQuery query;
};

/// Rays that have broken indices before, around a cloud: random ones, through points and between them, along
/// axes with zeros of both signs, inside box faces, starting in points, beside points, from up to 10^6 m
/// away; each with a random choice of radius (0 to larger than the cloud), interval, measure and entry_min.
std::vector<RayCase> ray_cases(const PointCloud& cloud, std::size_t count, Random& random);

}  // namespace alidade::test
