// SPDX-License-Identifier: MIT
// LAS files that other programs wrote. Expected values were taken from the files' bytes with a few lines of
// Python.
#include <gtest/gtest.h>
#include <filesystem>

#include <algorithm>
#include <cmath>

#include "base/bytes.h"
#include "cloud/las/write_las.h"
#include "tests/cloud/cloud_test_support.h"

namespace alidade {
namespace {

using test::error_of;
using test::k_no_shared_data;
using test::shared_data;
using test::warns;

struct Expected {
  const char* name;
  const char* version;
  int point_format;
  std::size_t point_count;
  LatticePosition first, last;
  int first_intensity;
  bool wkt, geotiff;
};

class LasSharedDataTest : public ::testing::TestWithParam<Expected> {};

TEST_P(LasSharedDataTest, counts_ends_and_crs_are_those_of_the_file) {
  const Expected& expected = GetParam();
  const std::filesystem::path path = shared_data(expected.name);
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  ASSERT_EQ(cloud.size(), expected.point_count);
  EXPECT_EQ(cloud.files[0].version, expected.version);
  EXPECT_EQ(cloud.files[0].point_format, expected.point_format);
  EXPECT_EQ(cloud.files[0].point_count, expected.point_count);
  EXPECT_EQ(cloud.positions.front(), expected.first);
  EXPECT_EQ(cloud.positions.back(), expected.last);
  EXPECT_EQ(cloud.intensities.front(), expected.first_intensity);
  EXPECT_EQ(!cloud.crs.wkt.empty(), expected.wkt);
  EXPECT_EQ(!cloud.crs.geotiff_keys.empty(), expected.geotiff);
}

TEST_P(LasSharedDataTest, written_and_read_again_it_is_the_same_cloud) {
  const std::filesystem::path path = shared_data(GetParam().name);
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  const std::filesystem::path copy =
      std::filesystem::temp_directory_path() / ("written_" + path.filename().string());
  write_las(copy, cloud, {.overwrite = true});
  const PointCloud again = read_cloud(copy);
  std::filesystem::remove(copy);
  EXPECT_EQ(cloud.lattice, again.lattice);
  EXPECT_TRUE(test::same_bits(cloud.positions, again.positions));
  EXPECT_TRUE(test::same_bits(cloud.colors, again.colors));
  EXPECT_TRUE(test::same_bits(cloud.intensities, again.intensities));
  EXPECT_TRUE(test::same_bits(cloud.returns, again.returns));
  EXPECT_TRUE(test::same_bits(cloud.flags, again.flags));
  EXPECT_TRUE(test::same_bits(cloud.classifications, again.classifications));
  if (!cloud.gps_times.empty()) {
    EXPECT_TRUE(test::same_bits(cloud.gps_times, again.gps_times));
  }
  EXPECT_EQ(cloud.crs, again.crs);
  EXPECT_EQ(cloud.records, again.records);
}

INSTANTIATE_TEST_SUITE_P(, LasSharedDataTest,
                         ::testing::Values(Expected{"lidar/pdrf0_pennsylvania.las",
                                                    "1.0",
                                                    0,
                                                    11781,
                                                    {248357460, 36658890, 148148},
                                                    {248391977, 36624761, 150532},
                                                    159,
                                                    false,
                                                    true},
                                           Expected{"lidar/autzen-utm.las",
                                                    "1.2",
                                                    3,
                                                    1065,
                                                    {49442861, 487745558, 13157},
                                                    {49449024, 487874167, 12921},
                                                    143,
                                                    true,  // in a record of libLAS
                                                    true},
                                           Expected{"lidar/vegetation_1_3.las",
                                                    "1.3",
                                                    1,
                                                    10683,
                                                    {-13688, 18447, -1594},
                                                    {-11745, 14261, 45},
                                                    3341,
                                                    false,
                                                    false},
                                           Expected{"lidar/test1_4.las",
                                                    "1.4",
                                                    6,
                                                    1000,
                                                    {1726072618, -860129774, -1746345863},
                                                    {1538225423, -864337581, -1747611844},
                                                    41,
                                                    true,
                                                    false},
                                           Expected{"lidar/1_4_w_evlr.las",
                                                    "1.4",
                                                    6,
                                                    1000,
                                                    {1726072618, -860129774, -1746345863},
                                                    {1538225423, -864337581, -1747611844},
                                                    41,
                                                    true,
                                                    false},
                                           Expected{"lidar/epsg_4326.las",
                                                    "1.2",
                                                    0,
                                                    5380,
                                                    {-946639387, 310367341, 478700002},
                                                    {-946803588, 310473291, 526800002},
                                                    65535,
                                                    false,
                                                    true},
                                           Expected{"lidar/extrabytes.las",
                                                    "1.4",
                                                    3,
                                                    1065,
                                                    {63701224, 84902831, 43166},
                                                    {63734285, 85324032, 42392},
                                                    143,
                                                    false,
                                                    false},
                                           Expected{"lidar/file_with_both_wkt_and_geotiff_vlrs.las",
                                                    "1.4",
                                                    6,
                                                    25408,
                                                    {180750, 1324040, 1354220},
                                                    {180740, 1301550, 1365010},
                                                    42399,
                                                    true,
                                                    true},
                                           Expected{"lidar_rgb/autzen_stadium_crop.las",
                                                    "1.2",
                                                    2,
                                                    1032668,
                                                    {-53680, 13580, -9135},
                                                    {71388, 131680, -8669},
                                                    122,
                                                    true,
                                                    false},
                                           Expected{"lidar_rgb/autzen_trim_7.las",
                                                    "1.4",
                                                    7,
                                                    110000,
                                                    {63717798, 84939395, 41119},
                                                    {63603788, 84933694, 42320},
                                                    4,
                                                    true,
                                                    false},
                                           Expected{"lidar_rgb/4_6_crop.las",
                                                    "1.2",
                                                    3,
                                                    23875,
                                                    {163979846, 145450025, 709126},
                                                    {163960323, 145469971, 709430},
                                                    2,
                                                    false,
                                                    true},
                                           Expected{"lidar_rgb/certainty3d-color-utm-feet-navd88.las",
                                                    "1.2",
                                                    3,
                                                    10126,
                                                    {-737787512, 118947088, -123656394},
                                                    {-693435099, 567821755, -476222137},
                                                    1906,
                                                    false,
                                                    true},
                                           Expected{"lidar_rgb/warsaw_small.las",
                                                    "1.2",
                                                    3,
                                                    3000,
                                                    {94497, 15444, 8482},
                                                    {93040, 17088, 10286},
                                                    633,
                                                    false,
                                                    false}),
                         [](const auto& test) {
                           std::string name = std::filesystem::path(test.param.name).stem().string();
                           std::replace_if(
                               name.begin(), name.end(),
                               [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
                           return name;
                         });

TEST(LasSharedFilesTest, legacy_fields_of_a_first_point_are_as_stored) {
  const std::filesystem::path path = shared_data("lidar/autzen-utm.las");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  EXPECT_EQ(cloud.returns[0], (ReturnNumbers{.number = 1, .count = 1}));  // 73 = 0b01'001'001
  EXPECT_EQ(cloud.flags[0], 64);
  EXPECT_EQ(cloud.classifications[0], 1);
  EXPECT_EQ(cloud.scan_angles[0], -9.0f);
  EXPECT_EQ(cloud.user_data[0], 132);
  EXPECT_EQ(cloud.point_source_ids[0], 7326);
  EXPECT_EQ(cloud.gps_times[0], 245380.78254962614);
  EXPECT_EQ(cloud.colors[0], Color16(68 * 257, 77 * 257, 88 * 257));
  EXPECT_EQ(cloud.crs.geotiff_ascii, std::string("NAD83 / UTM zone 10N|NAD83|\0", 28));
}

TEST(LasSharedFilesTest, fields_of_format_6_are_as_stored) {
  const std::filesystem::path path = shared_data("lidar/1_4_w_evlr.las");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  EXPECT_EQ(cloud.returns[0], (ReturnNumbers{.number = 1, .count = 1}));
  EXPECT_EQ(cloud.flags[0], 72);  // overlap and scan direction
  EXPECT_EQ(cloud.classifications[0], 2);
  EXPECT_FLOAT_EQ(cloud.scan_angles[0], 18.03f);
  EXPECT_EQ(cloud.point_source_ids[0], 202);
  EXPECT_EQ(cloud.gps_times[0], 83177420.53400505);
  EXPECT_TRUE(cloud.gps_time_is_standard);
  EXPECT_EQ(cloud.crs.wkt.substr(0, 47), "PROJCS[\"NAD83(HARN) / New Mexico Central (ftUS)");
  ASSERT_EQ(cloud.records.size(), 2u);
  EXPECT_EQ(cloud.records[1].user_id, "pylastest");
  EXPECT_EQ(cloud.records[1].record_id, 42);
  EXPECT_EQ(std::string(cloud.records[1].data.begin(), cloud.records[1].data.end()), "Test 1 2 ... 1 2");
  EXPECT_TRUE(cloud.records[1].extended);
}

TEST(LasSharedFilesTest, extra_dimensions_repeat_standard_fields_in_this_file) {
  const std::filesystem::path path = shared_data("lidar/extrabytes.las");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud =
      read_cloud(path, {.attributes = AttributeSet::all(), .color_depth = ColorDepth::bits_16});
  ASSERT_EQ(cloud.extra_dimensions.size(), 5u);
  const ExtraDimension& colors = cloud.extra_dimensions[0];
  const ExtraDimension& intensity = cloud.extra_dimensions[3];
  const ExtraDimension& time = cloud.extra_dimensions[4];
  EXPECT_EQ(colors.name, "Colors");
  EXPECT_EQ(colors.type, ScalarType::bytes);
  EXPECT_EQ(intensity.name, "Intensity");
  EXPECT_EQ(intensity.type, ScalarType::uint32);
  EXPECT_EQ(time.type, ScalarType::uint64);
  const auto* const color_bytes = reinterpret_cast<const std::byte*>(colors.values.data());
  const auto* const intensity_bytes = reinterpret_cast<const std::byte*>(intensity.values.data());
  const auto* const time_bytes = reinterpret_cast<const std::byte*>(time.values.data());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ASSERT_EQ(load<Color16>(color_bytes + 6 * i), cloud.colors[i]);
    ASSERT_EQ(load<std::uint32_t>(intensity_bytes + 4 * i), cloud.intensities[i]);
    ASSERT_EQ(static_cast<double>(load<std::uint64_t>(time_bytes + 8 * i)), std::floor(cloud.gps_times[i]));
  }
}

TEST(LasSharedFilesTest, autzen_has_8_bit_colours) {
  const std::filesystem::path path = shared_data("lidar_rgb/autzen_stadium_crop.las");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  ReadOptions options;
  options.attributes = Attribute::color;
  const PointCloud spread = read_cloud(path, options);
  EXPECT_TRUE(warns(spread, "assuming 8-bit colours (maximum 255)"));
  EXPECT_EQ(spread.colors.front(), Color16(203 * 257, 180 * 257, 145 * 257));
  EXPECT_EQ(spread.colors.back(), Color16(120 * 257, 119 * 257, 104 * 257));
  options.color_depth = ColorDepth::bits_16;
  EXPECT_EQ(read_cloud(path, options).colors.front(), Color16(203, 180, 145));
}

TEST(LasSharedFilesTest, warsaw_has_16_bit_colours_and_no_crs) {
  const std::filesystem::path path = shared_data("lidar_rgb/warsaw_small.las");
  if (path.empty()) GTEST_SKIP() << k_no_shared_data;
  const PointCloud cloud = read_cloud(path);
  EXPECT_EQ(cloud.colors.front(), Color16(32256, 30976, 26368));
  EXPECT_FALSE(warns(cloud, "colours"));
  EXPECT_TRUE(warns(cloud, "the WKT record contains no WKT"));
}

TEST(LasSharedFilesTest, damaged_files_are_errors) {
  if (shared_data("malformed").empty()) GTEST_SKIP() << test::absent("../shared/data/malformed", 4);
  const auto error = [](const char* name) {
    return error_of([&] { read_cloud(shared_data(std::string("malformed/") + name)); });
  };
  const auto contains = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(contains(error("1.2-with-color-clipped.las"),
                       "expected 1065 points of 34 bytes at byte 229, found 1064"));
  EXPECT_TRUE(contains(error("1.2-no-points.las"), "found 0"));
  EXPECT_TRUE(contains(error("garbage_nVariableLength.las"), "byte "));
  EXPECT_TRUE(contains(error("corrupt_crc.e57"), "page 33: corrupt page: wrong checksum"));
}

TEST(LasSharedFilesTest, odd_files_are_clean_reads) {
  if (shared_data("malformed").empty()) GTEST_SKIP() << test::absent("../shared/data/malformed", 4);
  const auto read = [](const char* name) {
    return read_cloud(shared_data(std::string("malformed/") + name));
  };
  const PointCloud keys = read("bad-geotiff-keys.las");
  EXPECT_EQ(keys.size(), 10u);
  EXPECT_TRUE(warns(keys, "bad-geotiff-keys.las: corrupt GeoTIFF keys"));
  EXPECT_NEAR(keys.world(0).y, 4320978.61, 1e-6) << "the two spare bytes of LAS 1.0 are not points";
  const PointCloud records = read("lots_of_vlr.las");
  EXPECT_EQ(records.size(), 1u);
  EXPECT_EQ(records.records.size(), 388u) << "390 less the two of the GeoTIFF keys";
  const PointCloud time = read("gps-time-nan.las");
  ASSERT_EQ(time.size(), 1u);
  EXPECT_TRUE(std::isnan(time.gps_times[0]));
  const PointCloud none = read("no-points.las");
  EXPECT_EQ(none.size(), 0u);
  EXPECT_FALSE(none.crs.empty());
}

}  // namespace
}  // namespace alidade
