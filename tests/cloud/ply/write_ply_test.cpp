// SPDX-License-Identifier: MIT
#include "cloud/ply/write_ply.h"

#include <cstring>
#include <fstream>
#include <iterator>

#include "cloud/point_cloud.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/read_alone.h"

namespace alidade::test {
namespace {

ExtraDimension extra(const char* name, ScalarType type, std::vector<std::uint8_t> values) {
  ExtraDimension dimension;
  dimension.name = name;
  dimension.type = type;
  dimension.byte_count = scalar_size(type);
  dimension.values = std::move(values);
  return dimension;
}

/// Two points with every attribute, UTM-like, on a lattice of centimetres.
PointCloud full_cloud() {
  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.01), glm::dvec3(690000, 5325000, 0)};
  cloud.positions = {{1234567, -7654321, 51234}, {2147483647, -2147483647, 0}};
  cloud.colors = {{257, 514, 65535}, {0, 128 * 257, 255 * 257}};
  cloud.near_infrared = {1, 65535};
  cloud.intensities = {0, 54321};
  cloud.classifications = {2, 255};
  cloud.returns = {{1, 2}, {15, 15}};
  cloud.flags = {0b10100101, 0b01011010};
  cloud.scan_angles = {-12.006f, 30.0f};
  cloud.user_data = {7, 255};
  cloud.point_source_ids = {65535, 3};
  cloud.gps_times = {-1.25, 123456789.123456};
  cloud.normals = {{0.0f, 0.6f, -0.8f}, {1.0f, 0.0f, 0.0f}};
  cloud.extra_dimensions = {
      extra("Amplitude", ScalarType::int16, {0x18, 0xfc, 1, 0}),
      extra("Pulse width", ScalarType::float32, {0, 0, 0x80, 0x3f, 0xcd, 0xcc, 0x8c, 0x3f})};
  return cloud;
}

PointCloud read_back(const std::filesystem::path& path, const Lattice& lattice) {
  const auto reader = open_ply(InputFile(path));
  PointCloud cloud;
  cloud.lattice = lattice;
  reader->survey({});
  reader->read(cloud, AttributeSet::all(), {}, {});
  return cloud;
}

class WritePly : public ::testing::TestWithParam<PlyEncoding> {};

TEST_P(WritePly, positions_and_attributes_come_back_as_they_were) {
  const std::filesystem::path path = test_folder() / "cloud.ply";
  const PointCloud cloud = full_cloud();
  write_ply(path, cloud, {.encoding = GetParam()});
  const PointCloud again = read_back(path, cloud.lattice);
  EXPECT_EQ(again.positions, cloud.positions);
  EXPECT_EQ(again.colors, cloud.colors);
  EXPECT_EQ(again.near_infrared, cloud.near_infrared);
  EXPECT_EQ(again.intensities, cloud.intensities);
  EXPECT_EQ(again.classifications, cloud.classifications);
  EXPECT_EQ(again.returns, cloud.returns);
  EXPECT_EQ(again.flags, cloud.flags);
  EXPECT_EQ(again.scan_angles, cloud.scan_angles);
  EXPECT_EQ(again.user_data, cloud.user_data);
  EXPECT_EQ(again.point_source_ids, cloud.point_source_ids);
  EXPECT_EQ(again.gps_times, cloud.gps_times);
  EXPECT_EQ(again.normals, cloud.normals);
  ASSERT_EQ(again.extra_dimensions.size(), 2u);
  EXPECT_EQ(again.extra_dimensions[0].name, "Amplitude");
  EXPECT_EQ(again.extra_dimensions[0].values, cloud.extra_dimensions[0].values);
  EXPECT_EQ(again.extra_dimensions[1].name, "Pulse_width");
  EXPECT_EQ(again.extra_dimensions[1].values, cloud.extra_dimensions[1].values);
}

TEST_P(WritePly, world_coordinates_are_written_without_rounding) {
  const std::filesystem::path path = test_folder() / "cloud.ply";
  const PointCloud cloud = full_cloud();
  write_ply(path, cloud, {.encoding = GetParam()});
  const auto survey = open_ply(InputFile(path))->survey({});
  EXPECT_EQ(survey.bounds.min, cloud.bounds().min);
  EXPECT_EQ(survey.bounds.max, cloud.bounds().max);
}

TEST_P(WritePly, pieces_make_the_bytes_of_the_whole) {
  const std::filesystem::path folder = test_folder();
  const PointCloud cloud = full_cloud();
  write_ply(folder / "whole.ply", cloud, {.encoding = GetParam()});
  PointCloud piece = cloud;
  const AttributeColumns columns = columns_of(cloud);
  const auto half = [&](std::size_t first) -> const PointCloud& {
    for_each_column(piece, columns,
                    [&](Attribute, auto& column, const auto& all) { column.assign(1, all[first]); });
    piece.positions = {cloud.positions[first]};
    for (std::size_t i = 0; i < cloud.extra_dimensions.size(); ++i) {
      const ExtraDimension& all = cloud.extra_dimensions[i];
      const auto begin = all.values.begin() + static_cast<std::ptrdiff_t>(first) * all.byte_count;
      piece.extra_dimensions[i].values.assign(begin, begin + all.byte_count);
    }
    return piece;
  };
  write_ply(folder / "pieces.ply", cloud.size(), half, {.encoding = GetParam()});
  const auto bytes = [&](const char* name) {
    std::ifstream in(folder / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(bytes("pieces.ply"), bytes("whole.ply"));
}

TEST_P(WritePly, a_cloud_without_points_or_attributes_can_be_written) {
  const std::filesystem::path path = test_folder() / "cloud.ply";
  PointCloud cloud;
  write_ply(path, cloud, {.encoding = GetParam()});
  EXPECT_EQ(read_back(path, cloud.lattice).size(), 0u);
  cloud.positions = {{1, 2, 3}};
  write_ply(path, cloud, {.encoding = GetParam(), .overwrite = true});
  const PointCloud again = read_back(path, cloud.lattice);
  EXPECT_EQ(again.positions, cloud.positions);
  EXPECT_EQ(again.attributes(), AttributeSet());
}

INSTANTIATE_TEST_SUITE_P(Encodings, WritePly,
                         ::testing::Values(PlyEncoding::ascii, PlyEncoding::binary_little_endian),
                         [](const auto& test) {
                           return test.param == PlyEncoding::ascii ? "ascii" : "binary";
                         });

TEST(WritePlyOptions, colours_are_rounded_to_8_bits) {
  const std::filesystem::path path = test_folder() / "cloud.ply";
  PointCloud cloud;
  cloud.positions.resize(1);
  cloud.colors = {{128, 129, 65406}};
  write_ply(path, cloud);
  EXPECT_EQ(read_back(path, cloud.lattice).colors[0], Color16(0, 257, 254 * 257));
}

TEST(WritePlyOptions, extra_dimensions_that_ply_does_not_support_are_written_as_double_or_left_out) {
  const std::filesystem::path path = test_folder() / "cloud.ply";
  PointCloud cloud;
  cloud.positions.resize(1);
  ExtraDimension scaled = extra("range", ScalarType::int16, {0x64, 0});
  scaled.scale = 0.25;
  scaled.offset = 3.0;
  scaled.has_scale = scaled.has_offset = true;
  ExtraDimension raw = extra("raw", ScalarType::bytes, {1, 2, 3});
  raw.byte_count = 3;
  cloud.extra_dimensions = {scaled, raw, extra("count", ScalarType::uint64, {1, 0, 0, 0, 1, 0, 0, 0}),
                            extra("intensity", ScalarType::uint8, {9}),
                            extra("range", ScalarType::uint8, {8})};
  write_ply(path, cloud);
  const PointCloud again = read_back(path, cloud.lattice);
  EXPECT_EQ(again.extra_dimensions.size(), 4u);
  EXPECT_EQ(extra_value<double>(again, "range", 0), 28.0);
  EXPECT_EQ(extra_value<double>(again, "count", 0), 4294967297.0);
  EXPECT_EQ(extra_value<std::uint8_t>(again, "extra_intensity", 0), 9);
  EXPECT_EQ(extra_value<std::uint8_t>(again, "extra_range", 0), 8);
  EXPECT_TRUE(again.intensities.empty());
}

TEST(WritePlyOptions, extra_dimensions_of_one_name_are_counted_on) {
  const std::filesystem::path path = test_folder() / "cloud.ply";
  PointCloud cloud;
  cloud.positions.resize(1);
  for (std::uint8_t i = 1; i <= 4; ++i)
    cloud.extra_dimensions.push_back(extra("same", ScalarType::uint8, {i}));
  cloud.extra_dimensions.push_back(extra("extra_same_3", ScalarType::uint8, {5}));
  cloud.extra_dimensions.push_back(extra("x", ScalarType::uint8, {6}));
  cloud.extra_dimensions.push_back(extra("x", ScalarType::uint8, {7}));
  write_ply(path, cloud);
  const PointCloud again = read_back(path, cloud.lattice);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < again.extra_dimensions.size(); ++i) {
    names.push_back(again.extra_dimensions[i].name);
    EXPECT_EQ(again.extra_dimensions[i].values, cloud.extra_dimensions[i].values);
  }
  EXPECT_EQ(names, (std::vector<std::string>{"same", "extra_same", "extra_same_2", "extra_same_3",
                                             "extra_extra_same_3", "extra_x", "extra_x_2"}));
}

TEST(WritePlyOptions, an_existing_file_is_kept_unless_overwriting) {
  const std::filesystem::path path = test_folder() / "cloud.ply";
  write_text(path, "precious");
  EXPECT_THROW(write_ply(path, full_cloud()), Error);
  EXPECT_EQ(read_bytes(path).size(), 8u);
  write_ply(path, full_cloud(), {.overwrite = true});
  EXPECT_GT(read_bytes(path).size(), 8u);
}

TEST(WritePlyOptions, a_stopped_task_leaves_no_file) {
  const std::filesystem::path folder = test_folder();
  EXPECT_THROW(write_ply(folder / "cloud.ply", full_cloud(), {.progress = [](auto, auto) { return false; }}),
               Cancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace alidade::test
