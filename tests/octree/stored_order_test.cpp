// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstring>

#include "octree/build.h"
#include "octree/query.h"
#include "octree/tree_walk.h"
#include "tests/support/point_families.h"

namespace alidade {
namespace {

using test::PointFamily;

TEST(StoredOrder, brings_every_attribute_to_its_point_and_needs_no_ids) {
  for (PointFamily& family : test::point_families()) {
    SCOPED_TRACE(family.name);
    PointCloud& cloud = family.cloud;
    const std::vector<LatticePosition> positions = cloud.positions;
    // The values of every column give the row they came from.
    ExtraDimension& row = cloud.extra_dimensions.emplace_back();
    row.type = ScalarType::uint32;
    row.byte_count = 4;
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      cloud.colors.emplace_back(i, 1, 2);
      cloud.gps_times.push_back(i);
      cloud.returns.push_back({static_cast<std::uint8_t>(i & 0xff), static_cast<std::uint8_t>(i >> 8)});
      row.values.resize(row.values.size() + 4);
      std::memcpy(row.values.data() + std::size_t{4} * i, &i, 4);
    }
    const Octree octree = build_in_stored_order(cloud);
    EXPECT_TRUE(cloud.positions.empty());
    EXPECT_TRUE(cloud.normals.empty());
    EXPECT_EQ(octree.view().ids, nullptr);
    const std::vector<LatticePosition> stored = positions_in_order(octree.view());
    ASSERT_EQ(stored.size(), positions.size());
    ASSERT_EQ(cloud.colors.size(), positions.size());
    std::vector<int> seen(positions.size());
    for (std::uint32_t index = 0; index < stored.size(); ++index) {
      ASSERT_EQ(point_id(octree.view(), index), index);
      const auto from = static_cast<std::uint32_t>(cloud.gps_times[index]);
      ASSERT_LT(from, positions.size());
      ++seen[from];
      ASSERT_EQ(stored[index], positions[from]);
      ASSERT_EQ(cloud.colors[index], Color16(from, 1, 2));
      ASSERT_EQ(cloud.returns[index].number + 256 * cloud.returns[index].count, static_cast<int>(from));
      std::uint32_t value;
      std::memcpy(&value, cloud.extra_dimensions[0].values.data() + std::size_t{4} * index, 4);
      ASSERT_EQ(value, from);
    }
    EXPECT_EQ(seen, std::vector<int>(positions.size(), 1));
  }
}

TEST(StoredOrder, nearest_of_points_of_one_position_are_those_of_the_lowest_ids) {
  for (std::size_t count = 250; count <= 270; ++count) {
    PointCloud cloud = test::make_cloud(std::vector<glm::dvec3>(count, glm::dvec3(1, 2, 3)),
                                        {glm::dvec3(0.001), glm::dvec3(0)});
    const Octree octree = build_in_stored_order(cloud);
    for (const std::size_t k : {1, 31, 32, 33, 40, 64, 65, 100, 200, 249}) {
      const std::vector<Hit> hits =
          find(octree, make_ray({0, 2, 3}, {1, 0, 0}), {.measure = Measure::t, .k = k});
      const std::vector<PointHit> neighbors = find(octree, glm::dvec3(0.0), {.k = k});
      ASSERT_EQ(hits.size(), k);
      ASSERT_EQ(neighbors.size(), k);
      for (std::size_t i = 0; i < k; ++i) {
        ASSERT_EQ(hits[i].point_id, i) << count << " points, k = " << k;
        ASSERT_EQ(neighbors[i].point_id, i) << count << " points, k = " << k;
      }
    }
  }
}

TEST(StoredOrder, takes_about_seven_bytes_per_point_on_a_scanned_surface) {
  test::Random random;
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 200000; ++i) {
    positions.push_back({random.between(0, 100), random.between(0, 100), random.between(0, 0.02)});
  }
  PointCloud cloud = test::make_cloud(positions, {glm::dvec3(0.001), glm::dvec3(0)});
  const Octree octree = build_in_stored_order(cloud);
  EXPECT_LT(static_cast<double>(octree.memory()) / static_cast<double>(octree.size()), 7.6);
}

}  // namespace
}  // namespace alidade
