// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "cloud/point_cloud.h"
#include "tests/support/random.h"

namespace alidade::test {

/// A cloud with a shape that is hard for an index in its own way.
struct PointFamily {
  std::string name;
  PointCloud cloud;
};

/// All families; sizes are small enough for brute force. Among them: uniform, grid, sphere shell, line, flat,
/// all equal, many points at few positions, two far clusters, a site far from invalid points at 0 0 0, huge
/// offset with small spread, one point, no point, anisotropic and very fine lattices, extents up to the whole
/// 32-bit range.
std::vector<PointFamily> point_families();

/// A cloud from world positions on a lattice.
PointCloud make_cloud(const std::vector<glm::dvec3>& positions, const Lattice& lattice);

}  // namespace alidade::test
