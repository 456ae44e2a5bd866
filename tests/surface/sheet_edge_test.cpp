// SPDX-License-Identifier: MIT
#include "surface/point_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "octree/build.h"
#include "octree/spacing.h"
#include "tests/support/random.h"
#include "tests/support/spacings.h"

namespace alidade {
namespace {

using test::Random;

/// Steps of a tenth of a millimetre.
PointCloud cloud_of(const std::vector<glm::dvec3>& positions) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(1e-4), .offset = {690000.0, 5325000.0, 600.0}};
  for (const glm::dvec3& position : positions)
    cloud.positions.emplace_back(glm::round(position / cloud.lattice.scale));
  return cloud;
}

SheetEdge edge_of_point(const Octree& octree, std::size_t id) {
  return edge_of(octree.layers(), id, surface_of(octree.layers(), id).normal);
}

TEST(SheetEdge, is_where_a_sheet_ends) {
  Random random("sheet_ends");
  const glm::dvec3 u = glm::normalize(glm::dvec3(1.0, 0.4, 0.2));
  const glm::dvec3 v = glm::normalize(glm::cross(u, glm::dvec3(0.1, -0.3, 1.0)));
  std::vector<glm::dvec3> positions;
  std::vector<double> from_edge;
  for (int i = 0; i < 8000; ++i) {
    const double across = random.between(0.0, 4.0);
    positions.push_back(across * u + random.between(-2.0, 2.0) * v);
    // Only the edge at 0 is tested, away from the corners.
    from_edge.push_back(across > 2.0 || std::fabs(glm::dot(positions.back(), v)) > 1.6 ? -1.0 : across);
  }
  const PointCloud cloud = cloud_of(positions);
  const Octree octree = with_surfaces(with_spacings(build(cloud), 8));
  const std::vector<double> spacings = test::spacings_by_id(octree);
  int near = 0, found = 0, straight = 0, far = 0, far_found = 0;
  double error = 0.0;
  for (std::size_t id = 0; id < positions.size(); ++id) {
    if (from_edge[id] < 0.0) continue;
    const SheetEdge edge = edge_of_point(octree, id);
    if (from_edge[id] > 2.5 * spacings[id]) {
      ++far;
      far_found += std::isfinite(edge.distance) ? 1 : 0;
    } else if (from_edge[id] < 0.4 * spacings[id]) {
      ++near;
      if (!std::isfinite(edge.distance)) continue;
      ++found;
      ASSERT_NEAR(glm::length(edge.direction), 1.0, 1e-9);
      straight += glm::dot(edge.direction, -u) > 0.85 ? 1 : 0;
      error += edge.distance - from_edge[id] / spacings[id];
    }
  }
  ASSERT_GT(near, 50);
  EXPECT_GT(found, 0.9 * near);
  EXPECT_GT(straight, 0.8 * found);
  EXPECT_NEAR(error / found, 0.0, 0.15);
  // Chance leaves gaps here and there.
  ASSERT_GT(far, 1000);
  EXPECT_LT(far_found, 0.04 * far);
}

TEST(SheetEdge, is_not_beside_lines_of_a_scan) {
  std::vector<glm::dvec3> positions;
  for (int line = 0; line < 9; ++line) {
    for (int i = 0; i < 200; ++i) positions.emplace_back(0.1 * i, 0.6 * line, 0.0);
  }
  const PointCloud cloud = cloud_of(positions);
  const Octree octree = with_surfaces(with_spacings(build(cloud), 8));
  for (std::size_t id = 200; id < 1600; ++id) {
    if (id % 200 < 10 || id % 200 >= 190) continue;
    ASSERT_TRUE(std::isinf(edge_of_point(octree, id).distance)) << id;
  }
}

}  // namespace
}  // namespace alidade
