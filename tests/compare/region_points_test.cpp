// SPDX-License-Identifier: MIT
#include "compare/change_regions.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "cloud/las/write_las.h"
#include "cloud/read_cloud.h"

namespace alidade::test {

using namespace compare;

namespace {

/// A row of pixels with these regions.
ChangeRegions changes_of(const std::vector<std::uint32_t>& labels) {
  ChangeRegions changes;
  changes.labels = labels;
  return changes;
}

TEST(RegionPoints, are_those_that_the_changed_pixels_show_each_once_by_id) {
  const std::vector<std::uint32_t> ids = {7, 3, 0, 3, 9, 5};
  const std::vector<RegionPoint> expected = {{2, 1}, {6, 2}, {8, 1}};
  EXPECT_EQ(region_points(ids, changes_of({2, 1, 1, 2, 1, 0}), 20), expected);
}

TEST(RegionPoints, objects_of_a_scene_are_left_out) {
  EXPECT_TRUE(
      region_points(std::vector<std::uint32_t>{4294967295u, 4294967290u}, changes_of({1, 1}), 20).empty());
}

TEST(RegionPoints, ids_of_another_cloud_are_errors) {
  EXPECT_THROW(region_points(std::vector<std::uint32_t>{21}, changes_of({1}), 20), Error);
  EXPECT_EQ(region_points(std::vector<std::uint32_t>{20}, changes_of({1}), 20).size(), 1u);
  // Ids where nothing changed are not used.
  EXPECT_TRUE(region_points(std::vector<std::uint32_t>{21}, changes_of({0}), 20).empty());
}

TEST(RegionPoints, a_layer_of_another_size_is_an_error) {
  EXPECT_THROW(region_points(std::vector<std::uint32_t>{1, 2}, changes_of({1}), 20), Error);
}

/// Ten points with colours and two further dimensions; one is called Region.
PointCloud small_cloud() {
  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.001), glm::dvec3(690000.0, 5325000.0, 600.0)};
  ExtraDimension height, region;
  height.name = "Height";
  height.type = ScalarType::uint16;
  height.byte_count = 2;
  region.name = "Region";
  region.type = ScalarType::uint8;
  region.byte_count = 1;
  for (int i = 0; i < 10; ++i) {
    cloud.positions.push_back({i, 2 * i, 3 * i});
    cloud.colors.push_back(Color16(static_cast<std::uint16_t>(1000 * i)));
    height.values.push_back(static_cast<std::uint8_t>(i));
    height.values.push_back(1);
    region.values.push_back(99);
  }
  cloud.extra_dimensions = {height, region};
  return cloud;
}

TEST(RegionPoints, are_written_as_las_with_all_attributes_and_the_number_of_their_region) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "region_points.las";
  const PointCloud cloud = small_cloud();
  write_las(file, points_of_regions(cloud, std::vector<RegionPoint>{{2, 1}, {6, 300}}), {.overwrite = true});
  const PointCloud read = read_cloud(file);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read.lattice.scale, cloud.lattice.scale);
  EXPECT_EQ(read.lattice.offset, cloud.lattice.offset);
  EXPECT_EQ(read.positions[0], cloud.positions[2]);
  EXPECT_EQ(read.positions[1], cloud.positions[6]);
  EXPECT_EQ(read.colors[1], cloud.colors[6]);
  ASSERT_EQ(read.extra_dimensions.size(), 2u);
  EXPECT_EQ(read.extra_dimensions[0].name, "Height");
  EXPECT_EQ(read.extra_dimensions[0].values, (std::vector<std::uint8_t>{2, 1, 6, 1}));
  EXPECT_EQ(read.extra_dimensions[1].name, "Region");
  EXPECT_EQ(read.extra_dimensions[1].type, ScalarType::uint32);
  EXPECT_EQ(read.extra_dimensions[1].values, (std::vector<std::uint8_t>{1, 0, 0, 0, 44, 1, 0, 0}));
}

}  // namespace
}  // namespace alidade::test
