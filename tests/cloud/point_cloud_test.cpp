// SPDX-License-Identifier: MIT
#include "cloud/point_cloud.h"

#include <gtest/gtest.h>

#include "cloud/rows.h"

namespace alidade {
namespace {

PointCloud three_points() {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.5), .offset = {100, 200, 300}};
  cloud.positions = {{2, -4, 6}, {-2, 4, 0}, {0, 0, 10}};
  return cloud;
}

TEST(PointCloudTest, bounds_are_those_of_the_points) {
  const Bounds bounds = three_points().bounds();
  EXPECT_EQ(bounds.min, glm::dvec3(99, 198, 300));
  EXPECT_EQ(bounds.max, glm::dvec3(101, 202, 305));
}

TEST(PointCloudTest, bounds_of_no_points_are_empty) {
  EXPECT_TRUE(PointCloud{}.bounds().empty());
}

TEST(PointCloudTest, attributes_are_the_columns_that_are_not_empty) {
  PointCloud cloud = three_points();
  EXPECT_EQ(cloud.attributes(), AttributeSet{});
  cloud.colors.resize(3);
  cloud.gps_times.resize(3);
  EXPECT_EQ(cloud.attributes(), Attribute::color | Attribute::gps_time);
  append_rows(cloud, AttributeSet::all(), 1);
  cloud.extra_dimensions.emplace_back();
  EXPECT_EQ(cloud.attributes(), AttributeSet::all());
}

TEST(PointCloudTest, attribute_names_come_in_the_order_of_the_bits) {
  const std::vector<std::string> names = attribute_names(AttributeSet::all());
  ASSERT_EQ(names.size(), 13u);
  EXPECT_EQ(names.front(), "color");
  EXPECT_EQ(names.back(), "extra_dimensions");
  EXPECT_EQ(attribute_names(Attribute::normal | Attribute::returns),
            (std::vector<std::string>{"return_number", "number_of_returns", "normal"}));
}

TEST(PointCloudTest, resize_takes_rows_out_of_every_column_that_is_present) {
  PointCloud cloud = three_points();
  cloud.intensities = {7, 8, 9};
  cloud.extra_dimensions.push_back({.name = "pair",
                                    .description = {},
                                    .type = ScalarType::uint16,
                                    .byte_count = 2,
                                    .no_data = {},
                                    .values = {1, 2, 3, 4, 5, 6}});
  cloud.resize(2);
  EXPECT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{7, 8}));
  EXPECT_EQ(cloud.extra_dimensions[0].values, (std::vector<std::uint8_t>{1, 2, 3, 4}));
  EXPECT_TRUE(cloud.colors.empty());
}

TEST(AppendRowsTest, new_columns_get_zeros_for_earlier_points_and_old_columns_for_new_ones) {
  PointCloud cloud = three_points();
  cloud.intensities = {7, 8, 9};
  append_rows(cloud, Attribute::color, 2);
  EXPECT_EQ(cloud.positions[4], LatticePosition(0));
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{7, 8, 9, 0, 0}));
  EXPECT_EQ(cloud.colors, std::vector<Color16>(5, Color16(0)));
  EXPECT_TRUE(cloud.normals.empty());
}

TEST(AppendRowsTest, columns_do_not_move_once_room_is_reserved) {
  PointCloud cloud;
  cloud.positions.reserve(1000);
  append_rows(cloud, AttributeSet::all(), 1);
  const auto* const positions = cloud.positions.data();
  const auto* const normals = cloud.normals.data();
  for (int i = 0; i < 999; ++i) append_rows(cloud, AttributeSet::all(), 1);
  EXPECT_EQ(cloud.positions.data(), positions);
  EXPECT_EQ(cloud.normals.data(), normals);
  EXPECT_EQ(cloud.normals.capacity(), 1000u);
}

TEST(AppendRowsTest, an_extra_dimension_is_found_by_its_meaning_or_made_with_zeros) {
  PointCloud cloud = three_points();
  ExtraDimension like;
  like.name = "height";
  like.type = ScalarType::float32;
  like.byte_count = 4;
  EXPECT_EQ(find_extra_dimension(cloud, like), 0u);
  EXPECT_EQ(cloud.extra_dimensions[0].values, std::vector<std::uint8_t>(12, 0));
  EXPECT_EQ(find_extra_dimension(cloud, like), 0u);
  EXPECT_EQ(find_extra_dimension(cloud, like, 1), 1u);
  like.has_scale = true;
  like.scale = 0.5;
  EXPECT_EQ(find_extra_dimension(cloud, like), 2u);
}

}  // namespace
}  // namespace alidade
