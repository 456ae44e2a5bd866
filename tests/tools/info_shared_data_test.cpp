// SPDX-License-Identifier: MIT
// What `alidade info` prints about files that other programs wrote, traps included.
#include <nlohmann/json.hpp>

#include "tests/support/absent_data.h"
#include "tests/tools/run_program.h"

namespace alidade::test {
namespace {

using Json = nlohmann::json;

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
