// SPDX-License-Identifier: MIT
#include "visibility/points/placement.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "base/error.h"
#include "tests/support/octrees.h"
#include "tests/support/point_families.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace visibility;

namespace {

TEST(ThinPoints, vs_brute_force_on_every_family) {
  for (const PointFamily& family : point_families()) {
    const Bounds bounds = family.cloud.bounds();
    const glm::dvec3 size = bounds.size();
    const double spacing = std::max(0.13 * std::max({size.x, size.y, size.z}), 1e-3);
    std::map<std::array<double, 3>, std::pair<double, std::uint64_t>> best;
    for (std::uint64_t id = 0; id < family.cloud.size(); ++id) {
      if (id % 3 == 0) continue;
      const glm::dvec3 position = family.cloud.world(id);
      std::array<double, 3> cell{};
      double sum = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = std::floor((position[axis] - bounds.min[axis]) / spacing);
        const double offset = position[axis] - (bounds.min[axis] + (cell[axis] + 0.5) * spacing);
        sum += offset * offset;
      }
      const std::pair<double, std::uint64_t> here{std::sqrt(sum), id};
      const auto [found, is_new] = best.try_emplace(cell, here);
      if (!is_new) found->second = std::min(found->second, here);
    }
    std::vector<std::uint64_t> expected;
    for (const auto& [cell, one] : best) expected.push_back(one.second);
    std::ranges::sort(expected);
    for (const auto& [name, octree] : octrees_of(family.cloud)) {
      std::vector<std::uint64_t> found;
      for (const PlacementTarget& target :
           thin_points(octree, spacing, [](std::uint64_t id) { return id % 3 != 0; })) {
        found.push_back(target.point_id);
        EXPECT_EQ(target.position, family.cloud.world(target.point_id));
      }
      std::ranges::sort(found);
      EXPECT_EQ(found, expected) << family.name << ", " << name;
    }
  }
}

TEST(ThinPoints, impossible_spacings_are_errors) {
  const Octree octree = build(make_cloud({{0, 0, 0}, {100, 0, 0}}, {glm::dvec3(0.001), glm::dvec3(0.0)}));
  EXPECT_THROW(thin_points(octree, 0.0), Error);
  EXPECT_THROW(thin_points(octree, -1.0), Error);
  EXPECT_THROW(thin_points(octree, std::nan("")), Error);
  EXPECT_THROW(thin_points(octree, 1e-5), Error);
  EXPECT_EQ(thin_points(octree, 1e-3).size(), 2u);
  EXPECT_EQ(thin_points(octree, 1e9).size(), 1u);
}

}  // namespace
}  // namespace alidade::test
