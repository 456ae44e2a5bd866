// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cloud/las/write_las.h"
#include "tests/support/absent_data.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

class InfoTest : public ProgramTest {};

TEST_F(InfoTest, json_has_the_keys_scripts_rely_on) {
  write_square("square.xyz");
  const ProgramResult result = run({"info", "--json", "square.xyz"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json info = Json::parse(result.out);
  EXPECT_EQ(info.at("points"), 400);
  ASSERT_EQ(info.at("files").size(), 1u);
  EXPECT_EQ(info.at("files")[0].at("file"), "square.xyz");
  EXPECT_EQ(info.at("files")[0].at("format"), "XYZ");
  EXPECT_TRUE(info.at("files")[0].at("version").is_string());
  EXPECT_TRUE(info.at("files")[0].at("point_format").is_null());
  EXPECT_EQ(info.at("files")[0].at("points"), 400);
  EXPECT_EQ(info.at("scale").size(), 3u);
  EXPECT_EQ(info.at("offset").size(), 3u);
  EXPECT_TRUE(info.at("attributes").is_array());
  EXPECT_TRUE(info.at("crs").is_null());
  EXPECT_TRUE(info.at("warnings").is_array());
}

TEST_F(InfoTest, bounds_are_those_of_the_points_within_the_stated_rounding) {
  write_square("square.xyz");
  const Json info = Json::parse(run({"info", "--json", "square.xyz"}).out);
  const double expected[2][3] = {{100.0, 200.0, 5.0}, {101.9, 201.9, 5.0}};
  for (int axis = 0; axis < 3; ++axis) {
    const double error = info.at("rounding_error")[axis].get<double>();
    EXPECT_NEAR(info.at("bounds").at("min")[axis].get<double>(), expected[0][axis], error + 1e-12);
    EXPECT_NEAR(info.at("bounds").at("max")[axis].get<double>(), expected[1][axis], error + 1e-12);
    EXPECT_LE(error, 0.05);
  }
}

TEST_F(InfoTest, the_rounding_of_float32_coordinates_is_stated) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\nelement vertex 400\nproperty float x\nproperty float "
      "y\nproperty float z\nend_header\n";
  for (int i = 0; i < 400; ++i) {
    for (const float value : {690000.0f + static_cast<float>(i), 5000000.0f + static_cast<float>(i), 1.0f})
      text.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  write("far.ply", text);
  const ProgramResult result = run({"info", "--json", "far.ply"});
  const Json info = Json::parse(result.out);
  EXPECT_EQ(info.at("rounding_error")[0], 0.03125);
  EXPECT_EQ(info.at("rounding_error")[1], 0.25);
  EXPECT_LT(info.at("rounding_error")[2].get<double>(), 1e-3);
  EXPECT_NE(info.at("warnings").dump().find("y in steps of 0.5"), std::string::npos) << info.at("warnings");
  EXPECT_NE(run({"info", "far.ply"}).out.find("0.03125 0.25"), std::string::npos);
}

TEST_F(InfoTest, bounds_have_no_digits_of_rounding) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.01), .offset = glm::dvec3(0.0)};
  cloud.positions = {{1, 42815, 37578}, {13639970, 84893520, 37579}};
  write_las(folder / "centimetres.las", cloud);
  ASSERT_NE(cloud.world(0).z, 375.78) << "0.01 times 37578 is 375.78000000000003";
  const std::string said = run({"info", "--json", "centimetres.las"}).out;
  const Json bounds = Json::parse(said).at("bounds");
  EXPECT_EQ(bounds.at("min"), Json::parse("[0.01, 428.15, 375.78]")) << said;
  EXPECT_EQ(bounds.at("max"), Json::parse("[136399.7, 848935.2, 375.79]")) << said;
  const std::string table = run({"sql", "centimetres.las", "SELECT y, z FROM points WHERE id = 0"}).out;
  EXPECT_NE(table.find("428.15  375.78\n"), std::string::npos) << table;
  const std::string csv = run({"sql", "centimetres.las", "SELECT z FROM points WHERE id = 0", "--csv"}).out;
  EXPECT_EQ(csv, "z\n375.78000000000003\n") << "scripts get the number itself";
}

TEST_F(InfoTest, several_files_are_one_cloud) {
  write_square("a.xyz");
  write("b.xyz", "0 0 0\n1 1 1\n");
  const Json info = Json::parse(run({"info", "--json", "a.xyz", "b.xyz"}).out);
  EXPECT_EQ(info.at("points"), 402);
  EXPECT_EQ(info.at("files").size(), 2u);
  EXPECT_NEAR(info.at("bounds").at("min")[0].get<double>(), 0.0, 1e-6);
}

TEST_F(InfoTest, generated_las_has_format_crs_and_exact_coordinates) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "3000", "-o", "yard.las", "-q"}).exit_code, 0);
  const Json info = Json::parse(run({"info", "--json", "yard.las"}).out);
  EXPECT_EQ(info.at("points"), 3000);
  EXPECT_EQ(info.at("files")[0].at("format"), "LAS");
  EXPECT_EQ(info.at("files")[0].at("version"), "1.4");
  EXPECT_EQ(info.at("files")[0].at("point_format"), 7);
  EXPECT_EQ(info.at("rounding_error"), Json({0.0, 0.0, 0.0}));
  EXPECT_TRUE(contains(info.at("crs").get<std::string>(), "UTM zone 32N"));
  const Json attributes = info.at("attributes");
  EXPECT_NE(std::find(attributes.begin(), attributes.end(), "color"), attributes.end());
}

TEST_F(InfoTest, header_box_that_is_not_that_of_the_points_gives_a_warning) {
  ASSERT_EQ(run({"generate", "courtyard", "--points", "3000", "-o", "yard.las", "-q"}).exit_code, 0);
  EXPECT_FALSE(contains(run({"info", "yard.las"}).out, "header box"));
  const Json info = Json::parse(run({"info", "--json", "yard.las"}).out);
  const double max_x = info.at("files")[0].at("header_box").at("max")[0].get<double>();
  EXPECT_NEAR(max_x, info.at("bounds").at("max")[0].get<double>(), 1e-9);

  const auto with_max_x = [&](double value) {
    std::fstream file(folder / "yard.las", std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(179).write(reinterpret_cast<const char*>(&value), sizeof value);
    file.close();
    return run({"info", "yard.las"}).out;
  };
  EXPECT_TRUE(contains(with_max_x(max_x + 0.002), "header box up to 0.0020 wider than the points"));
  EXPECT_TRUE(contains(with_max_x(max_x - 1.5), "header box excludes points by up to 1.5000"));
}

TEST_F(InfoTest, table_for_people_names_points_and_bounds) {
  write_square("square.xyz");
  const ProgramResult result = run({"info", "square.xyz"});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* const part : {"square.xyz", "400", "100", "101.9", "rounding", "CRS"}) {
    EXPECT_TRUE(contains(result.out, part)) << part << " in\n" << result.out;
  }
}

TEST_F(InfoTest, statistics_are_text_or_json) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(0.001), .offset = {690000, 5325000, 500}};
  for (int i = 0; i < 2000; ++i) {
    cloud.positions.push_back({37 * i % 10'000, 53 * i % 20'000, i});
    cloud.intensities.push_back(static_cast<std::uint16_t>(i));
    cloud.classifications.push_back(static_cast<std::uint8_t>(i % 3));
    cloud.returns.push_back({static_cast<std::uint8_t>(1 + i % 2), 2});
    cloud.flags.push_back(0b100);
    cloud.gps_times.push_back(2.5e8 + 0.5 * i);
  }
  cloud.gps_time_is_standard = true;
  write_las(folder / "site.las", cloud);
  const ProgramResult text = run({"info", "site.las", "--stats"});
  ASSERT_EQ(text.exit_code, 0) << text.err;
  for (const char* const part :
       {"classes\n", "  1 Unclassified", "returns\n", "  1 of 2", "flags\n", "withheld", "density     ",
        "time        2019-08-16T14:13:02Z to ", "written     by Alidade", "median", "intensity "})
    EXPECT_TRUE(contains(text.out, part)) << part << " is not in\n" << text.out;
  const Json json = Json::parse(run({"info", "site.las", "--stats", "--json"}).out).at("statistics");
  EXPECT_EQ(json.at("columns").at("intensity").at("count"), 2000);
  EXPECT_EQ(json.at("classes"), Json({{"0", 667}, {"1", 667}, {"2", 666}}));
  EXPECT_FALSE(contains(run({"info", "site.las"}).out, "density"));
}

TEST_F(InfoTest, formats_and_libraries_are_listed) {
  const ProgramResult formats = run({"formats"});
  EXPECT_EQ(formats.exit_code, 0);
  for (const char* const part : {"LAZ", ".copc.laz", "SQLite", "read, write"})
    EXPECT_TRUE(contains(formats.out, part)) << part;
  EXPECT_GT(Json::parse(run({"formats", "--json"}).out).size(), 10u);
  const std::string version = run({"--version"}).out;
  EXPECT_EQ(version.rfind("alidade ", 0), 0u);
  for (const char* const part : {"instruction set: ", "oneTBB ", "SQLite 3", "GDAL 3", "OpenImageIO 2"})
    EXPECT_TRUE(contains(version, part)) << version;
}

TEST_F(InfoTest, missing_file_is_named) {
  const ProgramResult result = run({"info", "absent.las"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(contains(result.err, "alidade: error: absent.las")) << result.err;
}

TEST_F(InfoTest, folder_instead_of_a_file_is_an_error) {
  const ProgramResult result = run({"info", "."});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_TRUE(contains(result.err, "alidade: error: .")) << result.err;
}

TEST_F(InfoTest, stdout_without_space_is_an_error) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  write_square("square.xyz");
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"info", "square.xyz"}, {"info", "--json", "square.xyz"}, {"--help"}}) {
    const ProgramResult result = run(words, "/dev/full");
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(contains(result.err, "standard output")) << result.err;
  }
}

// Files that other programs wrote, traps included.

struct Expected {
  const char* name;
  const char* format;
  int point_format;  ///< -1 = none
  std::uint64_t points;
  std::vector<const char*> said;  ///< parts of the table, or of a warning
};

class InfoSharedDataTest : public ProgramTest, public ::testing::WithParamInterface<Expected> {};

TEST_P(InfoSharedDataTest, counts_formats_and_traps_are_printed) {
  const Expected& expected = GetParam();
  const auto file = shared_data(expected.name);
  if (!file) GTEST_SKIP() << absent(std::string("../shared/data/") + expected.name);
  const ProgramResult json = run({"info", "--json", file->string()});
  ASSERT_EQ(json.exit_code, 0) << json.err;
  const Json info = Json::parse(json.out);
  EXPECT_EQ(info.at("points"), expected.points);
  ASSERT_EQ(info.at("files").size(), 1u);
  EXPECT_EQ(info.at("files")[0].at("format"), expected.format);
  const Json point_format = info.at("files")[0].at("point_format");
  EXPECT_EQ(point_format, expected.point_format < 0 ? Json() : Json(expected.point_format));

  const ProgramResult table = run({"info", file->string()});
  for (const char* const part : expected.said)
    EXPECT_NE((table.out + table.err).find(part), std::string::npos) << part << " in\n"
                                                                     << table.out << table.err;
}

const Expected k_files[] = {
    {"lidar_rgb/autzen_stadium_crop.las", "LAS", 2, 1032668, {"LAS 1.2", "assuming 8-bit colours"}},
    {"lidar_rgb/autzen_trim_7.las", "LAS", 7, 110000, {"LAS 1.4", "NAD_1983_HARN_Lambert_Conformal_Conic"}},
    {"lidar_rgb/autzen_trim.laz", "LAZ", 3, 110000, {"LAZ 1.2", "NAD_1983_HARN_Lambert_Conformal_Conic"}},
    {"lidar_rgb/lion_takanawa.copc.laz", "COPC", 7, 341989, {"header box", "0.005", "OriginId", "none"}},
    {"lidar_rgb/sample_lareunion_epsg2975.laz", "LAZ", 8, 59712, {"near_infrared", "UTM zone 40S"}},
    {"lidar_rgb/4_6_crop.las", "LAS", 3, 23875, {"EPSG:2903", "vertical EPSG:5103"}},
    {"lidar_rgb/certainty3d-color-utm-feet-navd88.las", "LAS", 3, 10126, {"EPSG:2229"}},
    {"lidar_rgb/warsaw_small.las", "LAS", 3, 3000, {"the WKT record contains no WKT"}},
    {"lidar_rgb/Semis_2022_0906_6665_LA93_IGN69_ok.laz", "LAZ", 7, 64572, {"Lambert-93"}},
    {"lidar/lone-star.laz",
     "LAZ",
     1,
     518862,
     {"LAZ 1.1", "EPSG:4326", "header box up to 0.00225",
      "the coordinate reference system is geocentric, but the points are"}},
    {"lidar/test1_4.las", "LAS", 6, 1000, {"New Mexico Central (ftUS)"}},
    {"lidar/1_4_w_evlr.las", "LAS", 6, 1000, {"New Mexico Central (ftUS)"}},
    {"lidar/file_with_both_wkt_and_geotiff_vlrs.las", "LAS", 6, 25408, {"NAD83_2011_Nebraska_ft"}},
    {"lidar/vegetation_1_3.las", "LAS", 1, 10683, {"LAS 1.3"}},
    {"lidar/epsg_4326.las", "LAS", 0, 5380, {"EPSG:4326"}},
    {"lidar/autzen-utm.las", "LAS", 3, 1065, {"UTM zone 10N"}},
    {"lidar/extrabytes.las", "LAS", 3, 1065, {"Colors, Reserved, Flags, Intensity, Time"}},
    {"lidar/pdrf0_pennsylvania.las", "LAS", 0, 11781, {"LAS 1.0", "EPSG:32128"}},
    {"pcd/region_growing_rgb_tutorial.pcd", "PCD", -1, 259847, {"47353 points without a position"}},
    {"pcd/FSite8_red2-utm.pcd", "PCD", -1, 21714, {"rounding"}},
    {"ply/small_gicp_source.ply", "PLY", -1, 69792, {"intensity"}},
    {"ply/platonic_shelf_big_endian.ply", "PLY", -1, 50, {"binary_big_endian"}},
    {"e57/bunnyDouble.e57", "E57", -1, 30571, {"'bunny'"}},
    {"e57/ColouredCubeFloat.e57", "E57", -1, 7680, {"color"}},
    {"e57/tiny_spherical.e57", "E57", -1, 180, {"180 points", "skipped"}},
    {"e57/A_moved_B.e57", "E57", -1, 6, {"2 records, no pose", "4 records, no pose"}},
    {"text/bunnyData.pts", "PTS", -1, 30571, {}},
    {"text/1.2-with-color.ptx", "PTX", -1, 1065, {"color"}},
    {"malformed/bad-geotiff-keys.las", "LAS", 1, 10, {"corrupt GeoTIFF keys"}},
    {"malformed/gps-time-nan.las", "LAS", 1, 1, {"gps_time"}},
    {"malformed/lots_of_vlr.las", "LAS", 1, 1, {}},
    {"malformed/no-points.las", "LAS", 3, 0, {}},
    {"malformed/laszip-generated_with2bytespadding.laz", "LAZ", 3, 1065, {}},
    {"malformed/simple-laszip-compressor-version-1.2r0.laz", "LAZ", 3, 1065, {}},
};

INSTANTIATE_TEST_SUITE_P(Files, InfoSharedDataTest, ::testing::ValuesIn(k_files));

}  // namespace
}  // namespace alidade::test
