// SPDX-License-Identifier: MIT
#include "cloud/las/write_las.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/bytes.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::error_of;
using test::read_memory;
using test::same_bits;
using test::sample_las;

/// Columns of `b` equal those of `a`; columns that only `b` has hold zeros.
void expect_same_points(const PointCloud& a, const PointCloud& b) {
  EXPECT_EQ(a.lattice, b.lattice);
  EXPECT_TRUE(same_bits(a.positions, b.positions));
  const auto same = [](const auto& column, const auto& other) {
    if (!column.empty()) return same_bits(column, other);
    const auto* const bytes = reinterpret_cast<const unsigned char*>(other.data());
    return std::all_of(bytes, bytes + other.size() * sizeof(other[0]),
                       [](unsigned char byte) { return byte == 0; });
  };
  EXPECT_TRUE(same(a.colors, b.colors));
  EXPECT_TRUE(same(a.near_infrared, b.near_infrared));
  EXPECT_TRUE(same(a.intensities, b.intensities));
  EXPECT_TRUE(same(a.classifications, b.classifications));
  EXPECT_TRUE(same(a.returns, b.returns));
  EXPECT_TRUE(same(a.flags, b.flags));
  EXPECT_TRUE(same(a.user_data, b.user_data));
  EXPECT_TRUE(same(a.point_source_ids, b.point_source_ids));
  EXPECT_TRUE(same(a.gps_times, b.gps_times));
  EXPECT_TRUE(same(a.normals, b.normals));
  ASSERT_EQ(a.extra_dimensions.size(), b.extra_dimensions.size());
  for (std::size_t i = 0; i < a.extra_dimensions.size(); ++i) {
    const ExtraDimension &x = a.extra_dimensions[i], &y = b.extra_dimensions[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.description, y.description);
    EXPECT_EQ(x.type, y.type);
    EXPECT_EQ(x.byte_count, y.byte_count);
    EXPECT_EQ(x.has_scale, y.has_scale);
    EXPECT_EQ(x.has_offset, y.has_offset);
    EXPECT_EQ(x.scale, y.scale);
    EXPECT_EQ(x.offset, y.offset);
    EXPECT_EQ(x.no_data, y.no_data);
    EXPECT_EQ(x.values, y.values);
  }
}

class LasRoundTripTest : public ::testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(, LasRoundTripTest, ::testing::Range(0, 11),
                         [](const auto& test) { return "format_" + std::to_string(test.param); });

TEST_P(LasRoundTripTest, las_to_cloud_to_las_to_cloud_is_equal_in_every_column) {
  const int format = GetParam();
  const std::filesystem::path path = test::test_folder() / "out.las";
  for (int version = test::oldest_las_version(format); version <= 4; ++version) {
    const PointCloud first = read_memory(build_las(sample_las(version, format, 500)));
    write_las(path, first, {.overwrite = true});
    const PointCloud second = read_cloud(path);
    expect_same_points(first, second);
    for (std::size_t i = 0; i < first.size(); ++i) {
      // Whole degrees of the old formats are not all multiples of the new 0.006 degrees.
      const float tolerance = format <= 5 ? 0.00301f : 0.0f;
      EXPECT_LE(std::abs(first.scan_angles[i] - second.scan_angles[i]), tolerance);
    }
    EXPECT_EQ(first.crs, second.crs);
    EXPECT_EQ(first.records, second.records);
    EXPECT_EQ(first.project_id, second.project_id);
    EXPECT_EQ(first.file_source_id, second.file_source_id);
    EXPECT_EQ(first.gps_time_is_standard, second.gps_time_is_standard);
    EXPECT_TRUE(second.warnings.empty());
    // From here on nothing changes any more, angles included: the bytes are those of the first writing.
    const std::filesystem::path again = path.parent_path() / "again.las";
    write_las(path, second, {.overwrite = true});
    write_las(again, read_cloud(path), {.overwrite = true});
    EXPECT_EQ(test::read_bytes(path), test::read_bytes(again));
  }
}

TEST(LasWriteTest, every_scan_angle_of_the_new_formats_survives) {
  test::LasFile file;
  file.version_minor = 4;
  file.point_format = 6;
  file.points.resize(65536);
  for (int i = 0; i < 65536; ++i) file.points[static_cast<std::size_t>(i)].scan_angle = i - 32768;
  const PointCloud cloud = read_memory(build_las(file));
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, cloud);
  EXPECT_TRUE(same_bits(cloud.scan_angles, read_cloud(path).scan_angles));
}

TEST(LasWriteTest, an_offset_without_a_scale_stays_one_and_returns_end_at_15) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.5), .offset = {10, 20, 30}};
  cloud.positions = {{1, 2, 3}};
  cloud.returns = {{17, 2}};
  ExtraDimension lifted = plain_dimension("lifted", ScalarType::uint8);
  lifted.has_offset = true;
  lifted.offset = 100.0;
  lifted.values = {7};
  cloud.extra_dimensions = {lifted};
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, cloud, {.overwrite = true});
  const PointCloud found = read_cloud(path);
  EXPECT_EQ(int{found.returns[0].number}, 15);
  EXPECT_EQ(int{found.returns[0].count}, 2);
  EXPECT_TRUE(found.extra_dimensions[0].has_offset);
  EXPECT_FALSE(found.extra_dimensions[0].has_scale);
  EXPECT_EQ(found.extra_dimensions[0].offset, 100.0);
}

TEST(LasWriteTest, the_header_has_counts_bounds_and_counts_by_return) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.5), .offset = {10, 20, 30}};
  cloud.positions = {{1, 2, 3}, {-5, 8, 1}, {0, 0, 0}, {2, 2, 2}};
  cloud.returns = {{1, 2}, {2, 2}, {15, 15}, {0, 0}};
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, cloud, {.creation_day = 32, .creation_year = 2026});
  const std::vector<std::byte> bytes = test::read_bytes(path);
  const std::byte* const at = bytes.data();
  ASSERT_EQ(bytes.size(), 375u + 4 * 30);
  EXPECT_EQ(load<std::uint16_t>(at + 90), 32);
  EXPECT_EQ(load<std::uint16_t>(at + 92), 2026);
  EXPECT_EQ(load<std::uint8_t>(at + 25), 4);
  EXPECT_EQ(load<std::uint8_t>(at + 104), 6);
  EXPECT_EQ(load<std::uint32_t>(at + 107), 0u) << "formats from 6 on have no legacy count";
  EXPECT_EQ(load<std::uint64_t>(at + 247), 4u);
  EXPECT_EQ(load<std::uint64_t>(at + 255), 1u);
  EXPECT_EQ(load<std::uint64_t>(at + 263), 1u);
  EXPECT_EQ(load<std::uint64_t>(at + 271), 0u);
  EXPECT_EQ(load<std::uint64_t>(at + 255 + 14 * 8), 1u);
  const double expected[] = {11, 7.5, 24, 20, 31.5, 30};  // x max, x min, y max, ...
  for (int i = 0; i < 6; ++i) EXPECT_EQ(load<double>(at + 179 + 8 * i), expected[i]);
}

TEST(LasWriteTest, the_point_format_is_the_smallest_that_holds_the_attributes) {
  const std::filesystem::path folder = test::test_folder();
  const auto format_of = [&](AttributeSet attributes) {
    PointCloud cloud;
    LasWriter writer(folder / "out.las", cloud, attributes, {.overwrite = true});
    writer.finish();
    return read_cloud(folder / "out.las").files[0].point_format;
  };
  EXPECT_EQ(format_of({}), 6);
  EXPECT_EQ(format_of(Attribute::gps_time | Attribute::intensity), 6);
  EXPECT_EQ(format_of(Attribute::color), 7);
  EXPECT_EQ(format_of(Attribute::near_infrared), 8);
}

TEST(LasWriteTest, batches_make_the_same_file_as_one_cloud) {
  const PointCloud cloud = read_memory(build_las(sample_las(4, 7, 5000)));
  const std::filesystem::path folder = test::test_folder();
  write_las(folder / "whole.las", cloud);
  PointCloud like = cloud;
  like.resize(0);
  LasWriter writer(folder / "parts.las", like, cloud.attributes());
  const std::vector<test::LasPoint> points = test::random_las_points(7, 5000, 13, 1);
  for (std::size_t first = 0; first < cloud.size(); first += 1234) {
    test::LasFile part = sample_las(4, 7, 0);
    const std::size_t last = std::min<std::size_t>(first + 1234, points.size());
    part.points.assign(points.begin() + static_cast<std::ptrdiff_t>(first),
                       points.begin() + static_cast<std::ptrdiff_t>(last));
    writer.write(read_memory(build_las(part)));
  }
  writer.finish();
  EXPECT_EQ(test::read_bytes(folder / "whole.las"), test::read_bytes(folder / "parts.las"));
}

TEST(LasWriteTest, missing_columns_are_written_as_zeros) {
  PointCloud like;
  const std::filesystem::path path = test::test_folder() / "out.las";
  LasWriter writer(path, like, Attribute::color | Attribute::normal);
  PointCloud batch;
  batch.positions = {{1, 2, 3}};
  writer.write(batch);
  writer.finish();
  const PointCloud cloud = read_cloud(path);
  EXPECT_EQ(cloud.colors, std::vector<Color16>{Color16(0)});
  EXPECT_EQ(cloud.normals, std::vector<glm::vec3>{glm::vec3(0)});
}

TEST(LasWriteTest, extra_dimensions_of_another_meaning_are_not_mixed_up) {
  const std::filesystem::path path = test::test_folder() / "out.las";
  PointCloud like;
  like.positions.resize(1);
  ExtraDimension& dimension = like.extra_dimensions.emplace_back();
  dimension.name = "Range";
  dimension.type = ScalarType::uint8;
  dimension.byte_count = 1;
  dimension.has_scale = true;
  dimension.scale = 0.5;
  dimension.values = {7};
  PointCloud batch = like;
  batch.extra_dimensions[0].scale = 0.25;
  LasWriter writer(path, like, like.attributes());
  writer.write(like);
  writer.write(batch);
  writer.finish();
  EXPECT_EQ(read_cloud(path).extra_dimensions.at(0).values, (std::vector<std::uint8_t>{7, 0}));
}

TEST(LasWriteTest, normals_survive_beside_extra_dimensions) {
  PointCloud cloud = read_memory(build_las(sample_las(4, 7, 3)));
  cloud.normals = {{0, 0, 1}, {0.6f, 0.8f, 0}, {-1, 0, 0}};
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, cloud);
  const PointCloud again = read_cloud(path);
  expect_same_points(cloud, again);
  EXPECT_EQ(again.extra_dimensions.size(), 4u);
}

TEST(LasWriteTest, wkt_and_geotiff_keys_survive_and_the_header_says_wkt) {
  PointCloud cloud;
  cloud.crs.wkt = "GEOGCS[\"y\"]";
  cloud.crs.geotiff_keys = {1, 1, 0, 0};
  cloud.crs.geotiff_doubles = {1.5};
  cloud.crs.geotiff_ascii = std::string("a|\0", 3);
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, cloud);
  EXPECT_EQ(read_cloud(path).crs, cloud.crs);
  EXPECT_EQ(load<std::uint16_t>(test::read_bytes(path).data() + 6), 16);
}

TEST(LasWriteTest, records_too_long_for_the_front_go_to_the_end) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  cloud.crs.wkt = "GEOGCS[\"" + std::string(70000, 'y') + "\"]";
  cloud.records.push_back(
      {.user_id = "long", .record_id = 1, .description = {}, .data = std::vector<std::uint8_t>(65536, 7)});
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, cloud);
  const PointCloud again = read_cloud(path);
  EXPECT_EQ(again.crs, cloud.crs);
  ASSERT_EQ(again.records.size(), 1u);
  EXPECT_EQ(again.records[0].data, cloud.records[0].data);
  EXPECT_EQ(again.size(), 1u);
}

TEST(LasWriteTest, long_names_are_cut_between_characters) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
  dimension.name = std::string(31, 'a') + "\u00e4";  // two bytes where one would fit
  dimension.values.resize(8);
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, cloud);
  EXPECT_EQ(read_cloud(path).extra_dimensions.at(0).name, std::string(31, 'a'));
}

TEST(LasWriteTest, names_that_the_cut_would_make_equal_stay_distinct_and_are_warned_of) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  const std::string stem = "C2C_absolute_distances[0.05]_max";  // 32 bytes
  for (const std::string name :
       {stem + "_(X)", stem + "_(Y)", std::string("short"), stem + "_(Z)", std::string("short")}) {
    ExtraDimension& dimension = cloud.extra_dimensions.emplace_back(plain_dimension(name, ScalarType::uint8));
    dimension.values = {static_cast<std::uint8_t>(cloud.extra_dimensions.size())};
  }
  const std::filesystem::path path = test::test_folder() / "out.las";
  std::vector<std::string> warnings;
  write_las(path, cloud, {.warn = [&](const std::string& text) { warnings.push_back(text); }});
  std::vector<std::string> names;
  std::vector<int> values;
  for (const ExtraDimension& dimension : read_cloud(path).extra_dimensions) {
    names.push_back(dimension.name);
    values.push_back(dimension.values.at(0));
  }
  const std::string shorter = stem.substr(0, 30);
  EXPECT_EQ(names, (std::vector<std::string>{stem, shorter + "_2", "short", shorter + "_3", "short"}));
  EXPECT_EQ(values, (std::vector<int>{1, 2, 3, 4, 5}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0], path.string() + ": LAS keeps 32 bytes of the names of extra dimensions: '" + stem +
                             "_(X)' becomes '" + stem + "', '" + stem + "_(Y)' becomes '" + shorter +
                             "_2', '" + stem + "_(Z)' becomes '" + shorter + "_3'");
}

TEST(LasWriteTest, undocumented_bytes_longer_than_one_entry_can_say_survive) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}, {4, 5, 6}};
  ExtraDimension& dimension = cloud.extra_dimensions.emplace_back();
  dimension.name = "blob";
  dimension.type = ScalarType::bytes;
  dimension.byte_count = 300;
  dimension.values.resize(600);
  for (std::size_t i = 0; i < 600; ++i) dimension.values[i] = static_cast<std::uint8_t>(i * 7);
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, cloud);
  const PointCloud again = read_cloud(path);
  ASSERT_EQ(again.extra_dimensions.size(), 2u);
  EXPECT_EQ(again.extra_dimensions[1].byte_count, 45);
  EXPECT_EQ(again.extra_dimensions[1].values[45], dimension.values[300 + 255]);
}

TEST(LasWriteTest, more_extra_dimensions_than_las_can_describe_are_an_error_and_no_file) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  for (int i = 0; i < 342; ++i) cloud.extra_dimensions.emplace_back().values.resize(8);
  const std::filesystem::path folder = test::test_folder();
  EXPECT_NE(error_of([&] { write_las(folder / "out.las", cloud); }).find("expected at most 341, found 342"),
            std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(LasWriteTest, without_finish_no_file_is_left) {
  const std::filesystem::path folder = test::test_folder();
  {
    PointCloud cloud;
    cloud.positions = {{1, 2, 3}};
    LasWriter writer(folder / "out.las", cloud, {});
    writer.write(cloud);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(LasWriteTest, an_existing_file_is_replaced_only_if_requested) {
  const std::filesystem::path path = test::test_folder() / "out.las";
  write_las(path, PointCloud{});
  EXPECT_NE(error_of([&] {
              write_las(path, PointCloud{});
            }).find("the file exists; expected another name, or --overwrite"),
            std::string::npos);
  write_las(path, PointCloud{}, {.overwrite = true});
}

TEST(LasWriteTest, writing_stops_when_requested_and_leaves_no_file) {
  const std::filesystem::path folder = test::test_folder();
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  LasWriteOptions options;
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(write_las(folder / "out.las", cloud, options), Cancelled);
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

}  // namespace
}  // namespace alidade
