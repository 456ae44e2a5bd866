// SPDX-License-Identifier: MIT
#include "cloud/text/write_text.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "cloud/ply/write_ply.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/las/las_builder.h"
#include "tests/cloud/read_alone.h"

namespace alidade::test {
namespace {

std::string written(const PointCloud& cloud, const TextWriteOptions& options = {}) {
  const std::filesystem::path path = test_folder() / "cloud.txt";
  write_text(path, cloud, options);
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(WriteTextTest, coordinates_have_the_decimals_of_the_lattice) {
  PointCloud cloud;
  cloud.lattice = {.scale = {0.001, 0.25, 1.0}, .offset = {690000.0, 0.5, 0.0}};
  cloud.positions = {{-61961, 3, 7}, {1, -2, 0}};
  EXPECT_EQ(written(cloud), "x,y,z\n689938.039,1.25,7\n690000.001,0.00,0\n");
  EXPECT_EQ(written(cloud, {.coordinates_alone = true}), "689938.039 1.25 7\n690000.001 0.00 0\n");
}

TEST(WriteTextTest, a_lattice_without_decimals_gets_as_many_digits_as_give_the_same_coordinate) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(1e-9 / 3.0), .offset = glm::dvec3(0.0)};
  cloud.positions = {{1, 2, 3}};
  EXPECT_EQ(written(cloud), "x,y,z\n3.3333333333333337e-10,6.666666666666667e-10,1e-09\n");
}

TEST(WriteTextTest, our_own_reader_gets_back_what_was_written) {
  for (const int format : {0, 3, 6, 7, 8}) {
    const PointCloud cloud = read_memory(build_las(sample_las(4, format, 200)));
    const std::filesystem::path path = test_folder() / "cloud.csv";
    write_text(path, cloud);
    const PointCloud back = read_cloud(path);
    ASSERT_EQ(back.size(), cloud.size());
    for (std::size_t row = 0; row < cloud.size(); ++row) {
      for (int axis = 0; axis < 3; ++axis)
        ASSERT_NEAR(back.world(row)[axis], cloud.world(row)[axis], 0.01 * cloud.lattice.scale[axis]);
    }
    EXPECT_EQ(back.colors, cloud.colors);
    EXPECT_EQ(back.near_infrared, cloud.near_infrared);
    EXPECT_EQ(back.intensities, cloud.intensities);
    EXPECT_EQ(back.classifications, cloud.classifications);
    EXPECT_EQ(back.returns, cloud.returns);
    EXPECT_EQ(back.flags, cloud.flags);
    EXPECT_TRUE(same_bits(back.scan_angles, cloud.scan_angles));
    EXPECT_EQ(back.user_data, cloud.user_data);
    EXPECT_EQ(back.point_source_ids, cloud.point_source_ids);
    EXPECT_TRUE(same_bits(back.gps_times, cloud.gps_times));
  }
}

TEST(WriteTextTest, our_own_reader_gets_back_names_with_separators_quotes_and_marks) {
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}};
  const std::vector<std::string> names = {"a,b", "a;b",  "say\"hi\"", "\"\"", "\"a\",\"b\";", "=x",
                                          "+1",  "-y,z", "a\"b",      "@\"",  "'t",           "it's"};
  for (const std::string& name : names) {
    cloud.extra_dimensions.push_back(plain_dimension(name, ScalarType::uint8));
    cloud.extra_dimensions.back().values = {7};
  }
  const std::filesystem::path path = test_folder() / "cloud.csv";
  write_text(path, cloud);
  std::vector<std::string> back;
  for (const ExtraDimension& dimension : read_cloud(path).extra_dimensions) back.push_back(dimension.name);
  EXPECT_EQ(back, names);
}

TEST(WriteTextTest, colours_of_8_bits_are_written_as_such) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}};
  cloud.colors = {{257, 514, 65535}, {0, 257, 0}};
  EXPECT_EQ(written(cloud), "x,y,z,red,green,blue\n0.000,0.000,0.000,1,2,255\n0.001,0.000,0.000,0,1,0\n");
  cloud.colors[0].x = 258;
  EXPECT_EQ(written(cloud, {.overwrite = true}),
            "x,y,z,red,green,blue\n0.000,0.000,0.000,258,514,65535\n0.001,0.000,0.000,0,257,0\n");
}

/// An extra dimension of these values, some of them nodata.
template <class Value, class Mark>
ExtraDimension marked(const std::string& name, ScalarType type, Mark mark, const std::vector<Value>& values) {
  ExtraDimension dimension = plain_dimension(name, type);
  dimension.values.resize(sizeof(Value) * values.size());
  std::memcpy(dimension.values.data(), values.data(), dimension.values.size());
  std::memcpy(dimension.no_data.emplace().data(), &mark, sizeof mark);
  return dimension;
}

TEST(WriteTextTest, values_that_are_marked_as_none_are_empty_cells_and_nan_in_ply) {
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(1.0);
  cloud.positions = {{1, 2, 3}, {4, 5, 6}};
  cloud.gps_times = {std::numeric_limits<double>::quiet_NaN(), 7.5};
  cloud.extra_dimensions = {
      marked("whole", ScalarType::int16, std::int64_t{-1}, std::vector<std::int16_t>{-1, 8}),
      marked("scaled", ScalarType::int16, std::int64_t{-32768}, std::vector<std::int16_t>{-32768, 150}),
      marked("large", ScalarType::uint64, std::uint64_t{UINT64_MAX},
             std::vector<std::uint64_t>{9, UINT64_MAX}),
      marked("short", ScalarType::float32, -9999.9, std::vector<float>{-9999.9f, 0.5f}),
      marked("real", ScalarType::float64, std::numeric_limits<double>::quiet_NaN(),
             std::vector<double>{std::numeric_limits<double>::quiet_NaN(), -9999.9})};
  cloud.extra_dimensions[1].has_scale = true;
  cloud.extra_dimensions[1].scale = 0.01;
  EXPECT_EQ(written(cloud),
            "x,y,z,gps_time,whole,scaled,large,short,real\n1,2,3,,,,9,,\n4,5,6,7.5,8,1.5,,0.5,-9999.9\n");

  const std::filesystem::path csv = test_folder() / "cloud.csv", ply = test_folder() / "cloud.ply";
  for (const bool is_text : {true, false}) {
    is_text ? alidade::write_text(csv, cloud) : write_ply(ply, cloud);
    const PointCloud back = read_cloud(is_text ? csv : ply);
    ASSERT_EQ(back.size(), 2u);
    EXPECT_TRUE(std::isnan(back.gps_times.at(0)));
    for (const char* const name : {"whole", "scaled"}) {
      EXPECT_TRUE(std::isnan(extra_value<double>(back, name, 0))) << name;
      EXPECT_FALSE(std::isnan(extra_value<double>(back, name, 1))) << name;
    }
    EXPECT_TRUE(std::isnan(extra_value<double>(back, "large", 1)));
  }
}

TEST(WriteTextTest, an_empty_cloud_is_a_header) {
  EXPECT_EQ(written({}), "x,y,z\n");
  EXPECT_EQ(written({}, {.coordinates_alone = true}), "");
}

TEST(DecimalsTest, are_the_fewest_that_lose_nothing) {
  const auto decimals = [](double scale, double offset) {
    return decimals_of({.scale = glm::dvec3(scale), .offset = glm::dvec3(offset)}, 0);
  };
  EXPECT_EQ(decimals(1.0, 5.0), 0);
  EXPECT_EQ(decimals(0.01, 690000.0), 2);
  EXPECT_EQ(decimals(0.01, 0.005), 3);
  EXPECT_EQ(decimals(1e-7, -94.0), 7);
  EXPECT_EQ(decimals(0.00025, 0.0), 5);
  EXPECT_EQ(decimals(0.003048, 0.0), 6);
  EXPECT_EQ(decimals(1.0 / 3.0, 0.0), 13);
  EXPECT_EQ(decimals(1e-9 / 3.0, 0.0), std::nullopt);
}

TEST(DecimalsTest, shown_are_those_or_a_thousandth_of_a_step) {
  const auto decimals = [](double scale, double offset) {
    return shown_decimals({.scale = glm::dvec3(scale), .offset = glm::dvec3(offset)}, 0);
  };
  EXPECT_EQ(decimals(0.01, 0.005), 3);
  EXPECT_EQ(decimals(1.0 / 1024.0, 0.0), 10) << "exact";
  constexpr double k_survey_foot = 1200.0 / 3937.0;
  EXPECT_EQ(decimals(0.01 * k_survey_foot, 0.0), 6);
  EXPECT_EQ(decimals(0.001 * k_survey_foot, 0.0), 7);
  EXPECT_EQ(decimals(k_survey_foot, 0.0), 4);
  EXPECT_EQ(decimals(1e-45, 0.0), std::nullopt);
}

}  // namespace
}  // namespace alidade::test
