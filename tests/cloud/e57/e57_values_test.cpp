// SPDX-License-Identifier: MIT
// What becomes of the values of E57 scans beside their coordinates, and how finely coordinates are kept.
#include <cmath>
#include <limits>
#include <utility>

#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/e57/e57_builder.h"
#include "tests/cloud/read_alone.h"

namespace alidade {
namespace {

using test::E57Builder;
using test::E57Column;
using test::expect_near;
using test::float32_column;
using test::float64_column;
using test::integer_column;
using test::pose_element;
using test::warns;

PointCloud read(const E57Builder& builder) {
  const std::string file = builder.file();
  return test::read_memory(std::as_bytes(std::span(file)));
}

/// Three points and more columns.
std::vector<E57Column> points_with(const std::vector<E57Column>& more) {
  std::vector<E57Column> columns = {float64_column("cartesianX", {1, 2, 3}),
                                    float64_column("cartesianY", {0, 0, 1}),
                                    float64_column("cartesianZ", {0, 1, 0})};
  columns.insert(columns.end(), more.begin(), more.end());
  return columns;
}

std::string color_limits(const std::string& type, const std::string& least, const std::string& most) {
  std::string text = "<colorLimits type=\"Structure\">";
  for (const std::string channel : {"Red", "Green", "Blue"}) {
    // The largest first, as some writers have it.
    text += "<color" + channel + "Maximum type=\"" + type + "\">" + most + "</color" + channel +
            "Maximum><color" + channel + "Minimum type=\"" + type + "\">" + least + "</color" + channel +
            "Minimum>";
  }
  return text + "</colorLimits>";
}

std::string intensity_limits(const std::string& least, const std::string& most) {
  return "<intensityLimits type=\"Structure\"><intensityMinimum type=\"Float\">" + least +
         "</intensityMinimum><intensityMaximum type=\"Float\">" + most +
         "</intensityMaximum></intensityLimits>";
}

std::vector<E57Column> colors(E57Column (*column)(const std::string&, const std::vector<double>&,
                                                  const std::string&),
                              const std::vector<double>& values) {
  return {column("colorRed", values, ""), column("colorGreen", values, ""), column("colorBlue", values, "")};
}

std::vector<E57Column> whole_colors(std::int64_t most, const std::vector<std::int64_t>& values) {
  return {integer_column("colorRed", 0, most, values), integer_column("colorGreen", 0, most, values),
          integer_column("colorBlue", 0, most, values)};
}

TEST(E57Color, limits_of_each_scan_say_what_is_full) {
  E57Builder builder;
  builder.add_scan(color_limits("Float", "0", "1"), points_with(colors(float32_column, {0, 0.5, 1})));
  builder.add_scan(color_limits("Integer", "", "255"), points_with(whole_colors(255, {0, 51, 255})));
  builder.add_scan(color_limits("Integer", "0", "65535"), points_with(whole_colors(65535, {0, 300, 65535})));
  builder.add_scan(color_limits("Integer", "0", "1023"), points_with(whole_colors(1023, {0, 341, 1023})));
  const PointCloud cloud = read(builder);
  const std::vector<int> expected = {0, 32768, 65535, 0, 13107, 65535, 0, 300, 65535, 0, 21845, 65535};
  ASSERT_EQ(cloud.colors.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(cloud.colors[i], Color16(static_cast<std::uint16_t>(expected[i]))) << i;
  EXPECT_TRUE(cloud.warnings.empty());
}

TEST(E57Color, scaled_limits_are_scaled) {
  E57Builder builder;
  builder.add_scan(
      "<colorLimits type=\"Structure\">"
      "<colorRedMinimum type=\"ScaledInteger\" scale=\"0.1\" offset=\"-1\">10</colorRedMinimum>"
      "<colorRedMaximum type=\"ScaledInteger\" scale=\"0.1\" offset=\"-1\">30</colorRedMaximum>"
      "<colorGreenMinimum type=\"Float\"/><colorGreenMaximum type=\"Float\">4</colorGreenMaximum>"
      "<colorBlueMinimum type=\"Float\"/><colorBlueMaximum type=\"Float\">2</colorBlueMaximum>"
      "</colorLimits>",
      points_with(colors(float64_column, {0, 1, 2})));
  EXPECT_EQ(read(builder).colors[1], Color16(32768, 16384, 32768)) << "each channel by its own";
}

TEST(E57Color, fields_without_limits_go_to_255_or_65535_whatever_occurs) {
  E57Builder builder;
  std::vector<E57Column> narrow = points_with({integer_column("colorRed", 17, 200, {17, 100, 200}),
                                               integer_column("colorGreen", 90, 90, {90, 90, 90}),
                                               integer_column("colorBlue", 0, 255, {0, 1, 2})});
  builder.add_scan("", narrow);
  builder.add_scan("", points_with(whole_colors(4095, {0, 4095, 1})));
  builder.add_scan("", points_with(whole_colors(60000, {0, 60000, 1})));
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.colors[0], Color16(17 * 257, 90 * 257, 0));
  EXPECT_EQ(cloud.colors[2], Color16(200 * 257, 90 * 257, 2 * 257));
  EXPECT_EQ(cloud.colors[4], Color16(65535));
  EXPECT_EQ(cloud.colors[7], Color16(60000));
}

TEST(E57Color, floats_without_limits_are_judged_by_what_occurs_with_a_warning) {
  E57Builder builder;
  builder.add_scan("", points_with(colors(float32_column, {0, 0.5, 0.75})));
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.colors[1], Color16(32768));
  EXPECT_TRUE(warns(cloud, "assuming that colours range from 0 to 1"));
}

TEST(E57Color, values_beyond_the_limits_widen_them_with_a_warning) {
  E57Builder builder;
  builder.add_scan(color_limits("Float", "0", "1"), points_with(colors(float32_column, {0, 51, 255})));
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.colors[1], Color16(13107));
  EXPECT_TRUE(
      warns(cloud, "scan 1: colours from 0 to 255 exceed the stated range of 0 to 1: using 0 to 255"));
}

TEST(E57Color, values_a_little_beyond_1_are_clamped_with_a_warning) {
  E57Builder builder;
  builder.add_scan(color_limits("Float", "0", "1"), points_with(colors(float64_column, {-0.25, 0.5, 1.25})));
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.colors[0], Color16(0));
  EXPECT_EQ(cloud.colors[1], Color16(32768));
  EXPECT_EQ(cloud.colors[2], Color16(65535));
  EXPECT_TRUE(warns(cloud,
                    "scan 1: colours from -0.25 to 1.25 exceed the stated range of 0 to 1: "
                    "clamped"));
}

TEST(E57Color, eight_bit_values_under_wide_limits_are_reported_not_guessed) {
  E57Builder builder;
  builder.add_scan(color_limits("Integer", "0", "65535"), points_with(whole_colors(65535, {0, 51, 255})));
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.colors[2], Color16(255));
  EXPECT_TRUE(warns(cloud, "but none exceeds 255: they may be 8-bit values"));
}

TEST(E57Intensity, limits_then_the_fields_range_then_what_occurs) {
  E57Builder builder;
  builder.add_scan(intensity_limits("-10", "10"), points_with({float32_column("intensity", {-10, 0, 10})}));
  builder.add_scan("", points_with({integer_column("intensity", 100, 300, {100, 200, 300})}));
  builder.add_scan(
      "", points_with({float32_column("intensity", {0, 0.25, 0.5}, "minimum=\"0\" maximum=\"0.5\"")}));
  builder.add_scan("", points_with({float32_column("intensity", {-1, 0, 3})}));
  builder.add_scan("", points_with({integer_column("intensity", 0, 0, {0, 0, 0})}));
  builder.add_scan(intensity_limits("0", "1"), points_with({float32_column("intensity", {0, 1, 2})}));
  const PointCloud cloud = read(builder);
  const std::vector<std::uint16_t> expected = {0, 32768, 65535, 0,     32768, 65535, 0, 32768, 65535,
                                               0, 16384, 65535, 16384, 16384, 16384, 0, 32768, 65535};
  EXPECT_EQ(cloud.intensities, expected) << "the constant 0 shares the scale of -1 to 3";
  EXPECT_TRUE(warns(cloud, "intensities were scaled from their minimum and maximum to 0 .. 65535"));
  EXPECT_TRUE(warns(cloud, "scan 6: intensities from 0 to 2 exceed the stated range of 0 to 1"));
}

TEST(E57Intensity, the_ends_of_whole_integer_types_are_no_scale) {
  constexpr std::int64_t k_least = std::numeric_limits<std::int64_t>::min(),
                         k_most = std::numeric_limits<std::int64_t>::max();
  for (const auto& [least, most] : {std::pair(k_least, k_most), std::pair(std::int64_t{0}, k_most),
                                    std::pair(std::int64_t{-2147483648}, std::int64_t{2147483647}),
                                    std::pair(std::int64_t{0}, std::int64_t{2147483647}),
                                    std::pair(std::int64_t{0}, std::int64_t{4294967295})}) {
    E57Builder builder;
    builder.add_scan("", points_with({integer_column("intensity", least, most, {0, 100, 255})}));
    EXPECT_EQ(read(builder).intensities, (std::vector<std::uint16_t>{0, 25700, 65535})) << most;
  }
  E57Builder builder;
  builder.add_scan("", points_with({integer_column("intensity", 0, 4294967295, {0, 2147483648, 4294967295},
                                                   " scale=\"1e-9\"")}));
  EXPECT_EQ(read(builder).intensities[1], 32768) << "scaled integers are stated with a purpose";
}

TEST(E57Intensity, scans_without_values_leave_the_scale_of_the_others_alone) {
  E57Builder builder;
  const auto columns = [](const std::vector<std::int64_t>& states) {
    std::vector<E57Column> all = points_with(colors(float32_column, {0, 0.5, 0.75}));
    all.push_back(float32_column("intensity", {0, 0.5, 0.75}));
    all.push_back(integer_column("cartesianInvalidState", 0, 2, states));
    return all;
  };
  builder.add_scan("", columns({0, 0, 0}));
  builder.add_scan("", columns({2, 2, 2}));
  builder.add_scan("", columns({0, 0, 0}), {}, 0);
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{0, 32768, 49151}));
  EXPECT_EQ(cloud.colors[1], Color16(32768));
  EXPECT_TRUE(warns(cloud, "assuming that colours range from 0 to 1"));
  EXPECT_TRUE(warns(cloud, "assuming that intensities range from 0 to 1"));
}

TEST(E57Invalid, points_without_a_position_are_left_out_and_counted) {
  E57Builder builder;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  builder.add_scan(
      "", {float64_column("cartesianX", {1, 2, 3, nan, 5}), float64_column("cartesianY", {1, 2, 3, 4, 5}),
           float64_column("cartesianZ", {1, 2, 3, 4, 5}),
           integer_column("cartesianInvalidState", 0, 2, {0, 1, 2, 0, 0})});
  builder.add_scan(
      "", {float64_column("sphericalRange", {1, 2}), float64_column("sphericalAzimuth", {0, 0}),
           float64_column("sphericalElevation", {0, 0}), float32_column("sphericalInvalidState", {1, 0})});
  const PointCloud cloud = read(builder);
  ASSERT_EQ(cloud.size(), 3u);
  expect_near(cloud.world(1), {5, 5, 5}, 1e-6);
  expect_near(cloud.world(2), {2, 0, 0}, 1e-6);
  EXPECT_EQ(cloud.files[0].dropped_count, 4u);
  EXPECT_TRUE(warns(cloud, "skipped 2 points with a direction only"));
  EXPECT_TRUE(warns(cloud, "skipped 1 points that are flagged as invalid"));
  EXPECT_TRUE(warns(cloud, "skipped 1 points without finite coordinates"));
}

TEST(E57Invalid, spherical_coordinates_replace_invalid_cartesian_ones) {
  E57Builder builder;
  builder.add_scan("", points_with({integer_column("cartesianInvalidState", 0, 2, {0, 2, 1}),
                                    float64_column("sphericalRange", {9, 4, 9}),
                                    float64_column("sphericalAzimuth", {0, 0, 0}),
                                    float64_column("sphericalElevation", {0, 0, 0}),
                                    integer_column("sphericalInvalidState", 0, 2, {0, 0, 2})}));
  const PointCloud cloud = read(builder);
  ASSERT_EQ(cloud.size(), 2u);
  expect_near(cloud.world(0), {1, 0, 0}, 1e-6);
  expect_near(cloud.world(1), {4, 0, 0}, 1e-6);
}

TEST(E57Invalid, colours_intensities_and_times_become_0_and_are_counted) {
  E57Builder builder;
  std::vector<E57Column> columns = points_with(whole_colors(255, {255, 255, 255}));
  columns.push_back(integer_column("isColorInvalid", 0, 1, {0, 1, 1}));
  columns.push_back(integer_column("intensity", 0, 255, {255, 255, 255}));
  columns.push_back(integer_column("isIntensityInvalid", 0, 1, {1, 0, 0}));
  columns.push_back(float64_column("timeStamp", {1, 2, 3}));
  columns.push_back(integer_column("isTimeStampInvalid", 0, 1, {0, 0, 1}));
  builder.add_scan("", columns);
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.colors[0], Color16(65535));
  EXPECT_EQ(cloud.colors[1], Color16(0));
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{0, 65535, 65535}));
  EXPECT_EQ(cloud.gps_times, (std::vector<double>{1, 2, 0}));
  EXPECT_TRUE(warns(cloud, "2 points have a colour flagged as invalid"));
  EXPECT_TRUE(warns(cloud, "1 points have an intensity flagged as invalid"));
}

TEST(E57Invalid, colours_and_intensities_do_not_affect_the_scale) {
  E57Builder builder;
  std::vector<E57Column> columns = points_with(colors(float32_column, {0, 0.5, -9999}));
  columns.push_back(integer_column("isColorInvalid", 0, 1, {0, 0, 1}));
  columns.push_back(float32_column("intensity", {0, 0.5, -9999}));
  columns.push_back(integer_column("isIntensityInvalid", 0, 1, {0, 0, 1}));
  builder.add_scan("", columns);
  builder.add_scan(intensity_limits("0", "1") + color_limits("Float", "0", "1"), columns);
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.intensities, (std::vector<std::uint16_t>{0, 32768, 0, 0, 32768, 0}));
  EXPECT_EQ(cloud.colors[1], Color16(32768));
  EXPECT_EQ(cloud.colors[4], Color16(32768));
  EXPECT_FALSE(warns(cloud, "exceed the stated range of"));
}

TEST(E57Time, counts_from_the_start_of_the_scan_as_adjusted_standard_gps_time) {
  const auto start = [](const char* seconds) {
    return "<acquisitionStart type=\"Structure\"><dateTimeValue type=\"Float\">" + std::string(seconds) +
           "</dateTimeValue></acquisitionStart>";
  };
  E57Builder builder;
  builder.add_scan(start("1.3e+009"), points_with({float64_column("timeStamp", {0, 0.5, 1})}));
  builder.add_scan(start("1300000100"), points_with({float64_column("timeStamp", {0, 0.5, 1})}));
  const PointCloud cloud = read(builder);
  EXPECT_TRUE(cloud.gps_time_is_standard);
  EXPECT_EQ(cloud.gps_times,
            (std::vector<double>{300000000, 300000000.5, 300000001, 300000100, 300000100.5, 300000101}));
  builder.add_scan("", points_with({float64_column("timeStamp", {0, 0.5, 1})}));
  const PointCloud undated = read(builder);
  EXPECT_FALSE(undated.gps_time_is_standard);
  EXPECT_EQ(undated.gps_times[4], 0.5);
  EXPECT_TRUE(warns(
      undated,
      "time stamps are relative to the start of each scan, which the file does not state for every scan"));
}

TEST(E57Extra, rows_columns_returns_and_normals) {
  E57Builder builder;
  builder.add_scan(
      pose_element("0.70710678118654757 0 0 0.70710678118654757", "100 0 0"),
      points_with({integer_column("rowIndex", 0, 5000, {0, 4999, 7}),
                   float32_column("columnIndex", {1, 2, 3}), integer_column("returnIndex", 0, 3, {0, 1, 3}),
                   integer_column("returnCount", 1, 4, {1, 2, 4}), float32_column("nor:normalX", {1, 0, 0}),
                   float32_column("nor:normalY", {0, 1, 0}), float32_column("nor:normalZ", {0, 0, 1})}));
  builder.add_scan("", points_with({}));
  const PointCloud cloud = read(builder);
  EXPECT_EQ(test::extra_value<std::uint32_t>(cloud, "rowIndex", 1), 4999u);
  EXPECT_EQ(test::extra_value<std::uint32_t>(cloud, "columnIndex", 2), 3u);
  EXPECT_EQ(test::extra_value<std::uint32_t>(cloud, "rowIndex", 4), 0u);
  EXPECT_EQ(cloud.returns[0], (ReturnNumbers{1, 1}));
  EXPECT_EQ(cloud.returns[2], (ReturnNumbers{4, 4}));
  EXPECT_NEAR(cloud.normals[0].y, 1.0f, 1e-6f) << "turned like the points";
  EXPECT_NEAR(cloud.normals[1].x, -1.0f, 1e-6f);
  EXPECT_NEAR(cloud.normals[2].z, 1.0f, 1e-6f);
}

TEST(E57Extra, a_row_without_a_column_is_one_dimension) {
  E57Builder builder;
  builder.add_scan("", points_with({}));
  builder.add_scan("", points_with({integer_column("rowIndex", 0, 9, {1, 2, 3})}));
  const PointCloud cloud = read(builder);
  ASSERT_EQ(cloud.extra_dimensions.size(), 1u);
  EXPECT_EQ(test::extra_value<std::uint32_t>(cloud, "rowIndex", 2), 0u);
  EXPECT_EQ(test::extra_value<std::uint32_t>(cloud, "rowIndex", 5), 3u);
}

TEST(E57Extra, what_some_scans_lack_is_reported) {
  E57Builder builder;
  builder.add_scan("", points_with(whole_colors(255, {1, 2, 3})));
  builder.add_scan("", points_with({integer_column("intensity", 0, 9, {1, 2, 3})}));
  builder.add_scan("", points_with(whole_colors(255, {1, 2, 3})));
  builder.add_scan_element("", "", 0, 0);
  const PointCloud cloud = read(builder);
  EXPECT_TRUE(warns(cloud, "memory: 1 of 3 scans has no color; using 0"));
  EXPECT_TRUE(warns(cloud, "memory: 2 of 3 scans have no intensity; using 0"));
  EXPECT_EQ(cloud.warnings.size(), 2u);
}

TEST(E57Lattice, decimal_steps_are_kept_exactly_also_when_moved) {
  E57Builder builder;
  const std::vector<std::int64_t> steps = {-123456, 0, 99999};
  builder.add_scan(pose_element("", "690000.5 5325000.125 600"),
                   {integer_column("cartesianX", -200000, 200000, steps, " scale=\"0.001\""),
                    integer_column("cartesianY", -200000, 200000, steps, " scale=\"0.001\""),
                    integer_column("cartesianZ", -200000, 200000, steps, " scale=\"0.001\"")});
  const PointCloud cloud = read(builder);
  EXPECT_EQ(cloud.lattice.scale, glm::dvec3(0.001));
  EXPECT_NEAR(cloud.world(0).x, 690000.5 - 123.456, 1e-9);
  EXPECT_NEAR(cloud.world(2).y, 5325000.125 + 99.999, 1e-9);
}

TEST(E57Lattice, other_steps_stay_apart) {
  // Half a step off whole decimals: rounding to them would bring every other pair together.
  for (const char* const scale : {" scale=\"0.001\" offset=\"0.0005\"", " scale=\"0.0009765625\""}) {
    E57Builder builder;
    std::vector<std::int64_t> steps(1000);
    for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = static_cast<std::int64_t>(i);
    const std::vector<std::int64_t> zeros(steps.size(), 0);
    builder.add_scan("", {integer_column("cartesianX", 0, 1023, steps, scale),
                          integer_column("cartesianY", 0, 1, zeros, scale),
                          integer_column("cartesianZ", 0, 1, zeros, scale)});
    const PointCloud cloud = read(builder);
    for (std::size_t i = 1; i < steps.size(); ++i)
      ASSERT_NEAR(cloud.world(i).x - cloud.world(i - 1).x, cloud.world(1).x - cloud.world(0).x, 1.1e-4) << i;
  }
}

TEST(E57Lattice, floats_of_a_scan_far_away_keep_the_digits_they_have_near_its_scanner) {
  E57Builder builder;
  builder.add_scan(pose_element("", "690000 5325000 600"),
                   {float32_column("cartesianX", {1.00001, 1.00002, 9}),
                    float32_column("cartesianY", {1, 2, 9}), float32_column("cartesianZ", {1, 2, 9})});
  const PointCloud cloud = read(builder);
  EXPECT_NEAR(cloud.world(1).x - cloud.world(0).x, 1e-5, 1e-6);
  EXPECT_LE(cloud.lattice.scale.x, 1e-6);
}

}  // namespace
}  // namespace alidade
