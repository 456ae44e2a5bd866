// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "cloud/point_cloud.h"

namespace alidade::test {

/// A wall, 3 high, between two patches of ground, 20 x 20 in all.
inline PointCloud garden(const std::string& wkt) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000, 5325000, 600}};
  for (int x = 0; x <= 80; ++x) {
    for (int y = 0; y <= 80; ++y) cloud.positions.emplace_back(250 * x, 250 * y, 0);
  }
  for (int y = 0; y <= 80; ++y) {
    for (int z = 1; z <= 12; ++z) cloud.positions.emplace_back(10000, 250 * y, 250 * z);
  }
  for (const LatticePosition& position : cloud.positions)
    cloud.classifications.push_back(position.z > 0 ? 6 : 2);
  cloud.crs.wkt = wkt;
  return cloud;
}

inline const std::string k_metres = R"(LOCAL_CS["garden",UNIT["metre",1]])";

}  // namespace alidade::test
