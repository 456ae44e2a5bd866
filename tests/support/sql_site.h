// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/point_cloud.h"

namespace alidade::test {

/// A square of 20 by 20 points, 0.1 apart, the corner at (100, 200, 5).
inline PointCloud sql_site() {
  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.1), glm::dvec3(100, 200, 5)};
  for (int i = 0; i < 400; ++i) cloud.positions.push_back(LatticePosition(i % 20, i / 20, 0));
  return cloud;
}

}  // namespace alidade::test
