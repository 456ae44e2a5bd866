// SPDX-License-Identifier: MIT
// The LAS reader against files put together by las_builder.h: every version with every point format.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::error_of;
using test::LasFile;
using test::LasPoint;
using test::read_memory;
using test::sample_las;

const ReadOptions k_colors_as_they_are{.attributes = AttributeSet::all(), .color_depth = ColorDepth::bits_16};

class LasReadTest : public ::testing::TestWithParam<std::tuple<int, int>> {
 protected:
  int version() const { return std::get<0>(GetParam()); }
  int format() const { return std::get<1>(GetParam()); }
  bool legacy() const { return format() <= 5; }
};

INSTANTIATE_TEST_SUITE_P(, LasReadTest, ::testing::Combine(::testing::Range(0, 5), ::testing::Range(0, 11)),
                         [](const auto& test) {
                           return "version_1_" + std::to_string(std::get<0>(test.param)) + "_format_" +
                                  std::to_string(std::get<1>(test.param));
                         });

TEST_P(LasReadTest, every_field_of_every_point_arrives) {
  const LasFile file = sample_las(version(), format(), 100);
  const PointCloud cloud = read_memory(build_las(file), k_colors_as_they_are);
  ASSERT_EQ(cloud.size(), 100u);
  EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.01));
  EXPECT_EQ(cloud.lattice.offset, glm::dvec3(690000, 5325000, 500));
  EXPECT_EQ(cloud.gps_times.empty(), !test::las_format_has_time(format()));
  EXPECT_EQ(cloud.colors.empty(), !test::las_format_has_color(format()));
  EXPECT_EQ(cloud.near_infrared.empty(), !test::las_format_has_near_infrared(format()));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const LasPoint& point = file.points[i];
    EXPECT_EQ(cloud.positions[i], LatticePosition(point.x, point.y, point.z));
    EXPECT_EQ(cloud.intensities[i], point.intensity);
    EXPECT_EQ(cloud.returns[i].number, point.return_number);
    EXPECT_EQ(cloud.returns[i].count, point.return_count);
    const int flags = (point.synthetic ? 1 : 0) | (point.key_point ? 2 : 0) | (point.withheld ? 4 : 0) |
                      (point.overlap ? 8 : 0) | point.scanner_channel << 4 | (point.scan_direction ? 64 : 0) |
                      (point.edge ? 128 : 0);
    EXPECT_EQ(cloud.flags[i], flags);
    EXPECT_EQ(cloud.classifications[i], point.classification);
    EXPECT_FLOAT_EQ(cloud.scan_angles[i], legacy() ? static_cast<float>(point.scan_angle)
                                                   : static_cast<float>(point.scan_angle * 0.006));
    EXPECT_EQ(cloud.user_data[i], point.user_data);
    EXPECT_EQ(cloud.point_source_ids[i], point.point_source_id);
    if (!cloud.gps_times.empty()) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(cloud.gps_times[i]),
                std::bit_cast<std::uint64_t>(point.gps_time));
    }
    if (!cloud.colors.empty()) {
      EXPECT_EQ(cloud.colors[i], Color16(point.color[0], point.color[1], point.color[2]));
    }
    if (!cloud.near_infrared.empty()) {
      EXPECT_EQ(cloud.near_infrared[i], point.near_infrared);
    }
  }
}

TEST_P(LasReadTest, extra_bytes_become_dimensions_and_what_is_not_described_undocumented_bytes) {
  const LasFile file = sample_las(version(), format());
  const PointCloud cloud = read_memory(build_las(file));
  ASSERT_EQ(cloud.extra_dimensions.size(), 4u);
  const ExtraDimension& deviation = cloud.extra_dimensions[0];
  EXPECT_EQ(deviation.name, "Deviation");
  EXPECT_EQ(deviation.description, "about Deviation");
  EXPECT_EQ(deviation.type, ScalarType::float32);
  EXPECT_FALSE(deviation.has_scale || deviation.has_offset || deviation.no_data);
  const ExtraDimension& range = cloud.extra_dimensions[1];
  EXPECT_EQ(range.type, ScalarType::uint16);
  EXPECT_TRUE(range.has_scale && range.has_offset && range.no_data);
  EXPECT_EQ(range.scale, 0.01);
  EXPECT_EQ(range.offset, 100.0);
  EXPECT_EQ((*range.no_data)[0], 0x88);
  EXPECT_EQ(cloud.extra_dimensions[2].type, ScalarType::bytes);
  EXPECT_EQ(cloud.extra_dimensions[2].byte_count, 5);
  EXPECT_EQ(cloud.extra_dimensions[3].name, "undocumented");
  EXPECT_EQ(cloud.extra_dimensions[3].byte_count, 2);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::vector<std::uint8_t> joined;
    for (const ExtraDimension& dimension : cloud.extra_dimensions) {
      const auto first = dimension.values.begin() + static_cast<std::ptrdiff_t>(i) * dimension.byte_count;
      joined.insert(joined.end(), first, first + dimension.byte_count);
    }
    EXPECT_EQ(joined, file.points[i].extra);
  }
}

TEST_P(LasReadTest, crs_and_other_records_are_carried_along) {
  const PointCloud cloud = read_memory(build_las(sample_las(version(), format())));
  EXPECT_EQ(cloud.crs.wkt, "PROJCS[\"x\"]");
  ASSERT_EQ(cloud.records.size(), version() >= 4 ? 2u : 1u);
  EXPECT_EQ(cloud.records[0].user_id, "a survey");
  EXPECT_EQ(cloud.records[0].record_id, 77);
  EXPECT_EQ(cloud.records[0].description, "kept as it is");
  EXPECT_EQ(cloud.records[0].data, (std::vector<std::uint8_t>{1, 2, 3, 4, 5}));
  EXPECT_FALSE(cloud.records[0].extended);
  if (version() >= 4) {
    EXPECT_TRUE(cloud.records[1].extended);
  }
  ASSERT_EQ(cloud.files.size(), 1u);
  EXPECT_EQ(cloud.files[0].format, "LAS");
  EXPECT_EQ(cloud.files[0].version, "1." + std::to_string(version()));
  EXPECT_EQ(cloud.files[0].point_format, format());
  EXPECT_EQ(cloud.files[0].point_count, 20u);
}

TEST_P(LasReadTest, only_wanted_attributes_take_memory) {
  ReadOptions options;
  options.attributes = Attribute::intensity;
  const PointCloud cloud = read_memory(build_las(sample_las(version(), format())), options);
  EXPECT_EQ(cloud.attributes(), AttributeSet(Attribute::intensity));
  EXPECT_EQ(cloud.size(), 20u);
}

TEST(LasFileTest, more_points_than_a_block_holds_arrive_in_order) {
  LasFile file;
  file.point_format = 0;
  file.points.resize(200000);
  for (std::size_t i = 0; i < file.points.size(); ++i) file.points[i].x = static_cast<std::int32_t>(i * 7);
  std::uint64_t last = 0;
  ReadOptions options;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last);
    EXPECT_LE(done, total);
    last = done;
    return true;
  };
  const std::vector<std::byte> bytes = build_las(file);
  const PointCloud cloud = read_memory(bytes, options);
  ASSERT_EQ(cloud.size(), file.points.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    ASSERT_EQ(cloud.positions[i].x, static_cast<std::int32_t>(i * 7));
  EXPECT_EQ(last, bytes.size());
  EXPECT_EQ(cloud.positions.capacity(), cloud.size());
}

TEST(LasFileTest, reading_stops_when_requested) {
  ReadOptions options;
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  const std::vector<std::byte> bytes = build_las(sample_las(2, 2));
  EXPECT_THROW(read_memory(bytes, options), Cancelled);
}

TEST(LasFileTest, a_record_of_long_undocumented_bytes_is_cut_into_describable_pieces) {
  LasFile file = sample_las(2, 1, 3);
  file.records.clear();
  file.extra_bytes = 600;
  file.points = test::random_las_points(1, 3, 600, 5);
  const PointCloud cloud = read_memory(build_las(file));
  ASSERT_EQ(cloud.extra_dimensions.size(), 3u);
  EXPECT_EQ(cloud.extra_dimensions[0].byte_count, 255);
  EXPECT_EQ(cloud.extra_dimensions[2].byte_count, 90);
  EXPECT_EQ(cloud.extra_dimensions[2].values[90], file.points[1].extra[510]);
}

TEST(LasFileTest, withdrawn_pairs_and_triples_are_kept_as_bytes) {
  LasFile file = sample_las(4, 6, 3);
  file.records = {test::las_extra_bytes_record(
      {test::las_extra_bytes_entry(13, 0, "Pair"), test::las_extra_bytes_entry(29, 0, "Triple")})};
  file.extra_bytes = 4 + 12;
  file.points = test::random_las_points(6, 3, 16, 5);
  const PointCloud cloud = read_memory(build_las(file));
  ASSERT_EQ(cloud.extra_dimensions.size(), 2u);
  EXPECT_EQ(cloud.extra_dimensions[0].type, ScalarType::bytes);
  EXPECT_EQ(cloud.extra_dimensions[0].byte_count, 4);
  EXPECT_EQ(cloud.extra_dimensions[1].byte_count, 12);
  EXPECT_EQ(cloud.extra_dimensions[1].name, "Triple");
}

TEST(LasFileTest, an_extra_bytes_record_that_does_not_fit_is_a_warning_and_no_byte_is_lost) {
  LasFile file = sample_las(4, 6, 3);
  file.records = {test::las_extra_bytes_record(
      {test::las_extra_bytes_entry(10, 0, "A"), test::las_extra_bytes_entry(10, 0, "B")})};
  const PointCloud cloud = read_memory(build_las(file));
  ASSERT_EQ(cloud.extra_dimensions.size(), 1u);
  EXPECT_EQ(cloud.extra_dimensions[0].byte_count, 13);
  EXPECT_TRUE(test::warns(cloud, "does not match the 13 extra bytes"));
}

TEST(LasFileTest, two_dimensions_of_one_name_stay_two) {
  LasFile file = sample_las(4, 6, 3);
  file.records = {test::las_extra_bytes_record(
      {test::las_extra_bytes_entry(1, 0, "A"), test::las_extra_bytes_entry(1, 0, "A")})};
  file.extra_bytes = 2;
  file.points = test::random_las_points(6, 3, 2, 5);
  const PointCloud cloud = read_memory(build_las(file));
  ASSERT_EQ(cloud.extra_dimensions.size(), 2u);
  EXPECT_EQ(cloud.extra_dimensions[0].values[2], file.points[2].extra[0]);
  EXPECT_EQ(cloud.extra_dimensions[1].values[2], file.points[2].extra[1]);
}

TEST(LasFileTest, geotiff_keys_are_carried_along_as_they_are) {
  LasFile file = sample_las(2, 0, 1);
  file.records = {
      {"LASF_Projection", 34735, "", {1, 0, 1, 0, 0, 0, 1, 0, 0x00, 0x0c, 0, 0, 1, 0, 0x6e, 0x69}},
      {"LASF_Projection", 34736, "", {0, 0, 0, 0, 0, 0, 0xf0, 0x3f}},
      {"LASF_Projection", 34737, "", {'U', 'T', 'M', '|', 0}}};
  const PointCloud cloud = read_memory(build_las(file));
  EXPECT_EQ(cloud.crs.geotiff_keys, (std::vector<std::uint16_t>{1, 1, 0, 1, 3072, 0, 1, 26990}));
  EXPECT_EQ(cloud.crs.geotiff_doubles, std::vector<double>{1.0});
  EXPECT_EQ(cloud.crs.geotiff_ascii, std::string("UTM|\0", 5));
  EXPECT_FALSE(test::warns(cloud, "GeoTIFF"));
}

TEST(LasFileTest, wkt_of_liblas_is_used_if_there_is_no_other_and_its_record_is_kept) {
  LasFile file = sample_las(2, 1);
  const test::LasRecord old{"liblas", 2112, "", {'G', 'E', 'O', '[', ']', 0}};
  file.records = {old};
  const PointCloud alone = read_memory(build_las(file));
  EXPECT_EQ(alone.crs.wkt, "GEO[]");
  ASSERT_EQ(alone.records.size(), 1u);
  EXPECT_EQ(alone.records[0].data, old.data);
  file.records = {old, {"LASF_Projection", 2112, "", {'P', '[', ']', 0}}};
  EXPECT_EQ(read_memory(build_las(file)).crs.wkt, "P[]");
  file.records = {{"liblas", 2112, "", {'n', 'o', 'n', 'e'}}};
  const PointCloud other = read_memory(build_las(file));
  EXPECT_EQ(other.crs.wkt, "");
  EXPECT_EQ(other.records.size(), 1u);
}

TEST(LasFileTest, wkt_may_follow_the_points) {
  LasFile file = sample_las(4, 7, 1);
  std::swap(file.records, file.extended_records);
  EXPECT_EQ(read_memory(build_las(file)).crs.wkt, "PROJCS[\"x\"]");
}

TEST(LasFileTest, encoding_and_identity_come_from_the_header) {
  LasFile file = sample_las(4, 6, 1);
  file.global_encoding = 1 | 16;
  file.file_source_id = 4711;
  const PointCloud cloud = read_memory(build_las(file));
  EXPECT_TRUE(cloud.gps_time_is_standard);
  EXPECT_EQ(cloud.file_source_id, 4711);
  EXPECT_EQ(cloud.project_id[15], 15);
}

TEST(LasFileTest, reserved_bytes_of_old_versions_mean_nothing) {
  LasFile file = sample_las(0, 1, 1);
  file.global_encoding = 1;
  file.file_source_id = 4711;
  const PointCloud cloud = read_memory(build_las(file));
  EXPECT_FALSE(cloud.gps_time_is_standard);
  EXPECT_EQ(cloud.file_source_id, 0);
}

TEST(LasFileTest, wave_packets_are_left_out_with_a_warning) {
  LasFile file = sample_las(4, 9, 2);
  file.extended_records.push_back({"LASF_Spec", 65535, "waves", std::vector<std::uint8_t>(1000)});
  const PointCloud cloud = read_memory(build_las(file));
  EXPECT_EQ(cloud.records.size(), 2u);
  EXPECT_TRUE(test::warns(cloud, "wave packets are skipped"));
}

TEST(LasFileTest, counts_that_disagree_are_reported_and_the_64_bit_count_wins) {
  LasFile file = sample_las(4, 0, 5);
  std::vector<std::byte> bytes = build_las(file);
  bytes[107] = std::byte{3};
  EXPECT_EQ(read_memory(bytes).size(), 5u);
  EXPECT_TRUE(test::warns(read_memory(bytes), "the header has two numbers of points, 3 and 5"));
  bytes[247] = std::byte{0};
  EXPECT_EQ(read_memory(bytes).size(), 3u);
}

TEST(LasFileTest, no_points_are_a_clean_read) {
  for (int format = 0; format < 11; ++format) {
    const PointCloud cloud = read_memory(build_las(sample_las(4, format, 0)));
    EXPECT_EQ(cloud.size(), 0u);
    EXPECT_EQ(cloud.crs.wkt, "PROJCS[\"x\"]");
  }
}

}  // namespace
}  // namespace alidade
