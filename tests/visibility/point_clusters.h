// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <glm/common.hpp>

#include "cloud/point_cloud.h"
#include "tests/support/random.h"

// Points of one position. A scan may have a million of them: invalid returns at zero, or everything scanned
// twice.

namespace alidade::test {

inline void add(PointCloud& cloud, const glm::dvec3& position) {
  cloud.positions.emplace_back(glm::round(position / cloud.lattice.scale));
}

/// Ground, a wall and a bush, and clusters of equal points: at zero in the air, on the ground, in the bush
/// and on the wall.
inline PointCloud site_with_clusters(std::size_t points_of_cluster) {
  Random random("clusters");
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(1e-3), .offset = glm::dvec3(0)};
  const glm::dvec3 clusters[] = {{0, 0, 0}, {1, 1, -1.7}, {4, 3, -0.5}, {-3, 0, 1}};
  for (int i = 0; i < 3000; ++i) {
    add(cloud, {random.between(-6, 6), random.between(-6, 6), -1.7 + random.between(-0.01, 0.01)});
    if (i % 2 == 0)
      add(cloud, {-3 + random.between(-0.01, 0.01), random.between(-4, 4), random.between(-1.7, 2)});
    if (i % 5 == 0) add(cloud, glm::dvec3(4, 3, -0.5) + random.in_cube());
    if (static_cast<std::size_t>(i) < points_of_cluster)
      for (const glm::dvec3& cluster : clusters) add(cloud, cluster);
  }
  return cloud;
}

}  // namespace alidade::test
