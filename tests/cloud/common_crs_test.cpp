// SPDX-License-Identifier: MIT
// Coordinate reference systems of files that are to be one cloud.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cloud/crs.h"
#include "tests/cloud/cloud_test_support.h"
#include "tests/cloud/crs_of_keys.h"
#include "tests/cloud/las/las_builder.h"

namespace alidade {
namespace {

using test::build_las;
using test::crs_of_keys;
using test::error_of;
using test::LasFile;
using test::warns;

const char* const k_utm_32 =
    R"(PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",AUTHORITY["EPSG","4326"]],AUTHORITY["EPSG","32632"]])";
const char* const k_utm_33 =
    R"(PROJCS["WGS 84 / UTM zone 33N",GEOGCS["WGS 84",AUTHORITY["EPSG","4326"]],AUTHORITY["EPSG","32633"]])";
const char* const k_esri_32 = R"(PROJCS["WGS_1984_UTM_Zone_32N",GEOGCS["GCS_WGS_1984"]])";

TEST(CrsNameTest, a_system_is_called_by_its_wkt_else_by_its_codes) {
  EXPECT_EQ(crs_name(crs_of_wkt(k_utm_32)), "WGS 84 / UTM zone 32N");
  EXPECT_EQ(crs_name(crs_of_keys({3072, 32632, 4096, 5773})), "EPSG:32632, vertical EPSG:5773");
  EXPECT_EQ(crs_name(crs_of_keys({3072, 32767})), "GeoTIFF keys without EPSG code");
  EXPECT_EQ(crs_name({}), "none");
  const auto compound = [](const std::string& name) {
    return crs_name(
        crs_of_wkt("COMPD_CS[\"" + name + R"(",PROJCS["plane",GEOGCS["datum"]],VERT_CS["heights"]])"));
  };
  for (const char* const whole : {"", "unknown", "plane", "plane + unknown", "plane + heights"})
    EXPECT_EQ(compound(whole), "plane + heights") << whole;
  EXPECT_EQ(crs_name(crs_of_wkt("PROJCS[\"unknown\",GEOGCS[\"datum\"]]")), "a system without a name");
}

TEST(CompareCrsTest, systems_are_compared_by_their_codes_where_both_have_one) {
  using enum CrsAgreement;
  EXPECT_EQ(compare_crs(crs_of_wkt(k_utm_32), crs_of_keys({3072, 32632})), same);
  EXPECT_EQ(compare_crs(crs_of_wkt(k_utm_32), crs_of_keys({3072, 32633})), different);
  EXPECT_EQ(compare_crs(crs_of_wkt(k_utm_32), crs_of_wkt(k_utm_33)), different);
  EXPECT_EQ(compare_crs(crs_of_keys({2048, 4326}), crs_of_keys({2048, 4258})), different);
  EXPECT_EQ(compare_crs(crs_of_keys({3072, 32632, 2048, 4326}), crs_of_keys({3072, 32632})), same);
  EXPECT_EQ(compare_crs(crs_of_wkt(R"(GEODCRS["ETRS89",CS[ellipsoidal,2],ID["EPSG",4258]])"),
                        crs_of_keys({2048, 4258})),
            same);
  const std::string iso = R"(PROJCRS["other words",ID["EPSG",32632]])";
  EXPECT_EQ(compare_crs(crs_of_wkt(iso), crs_of_wkt(k_utm_32)), same);
  EXPECT_EQ(compare_crs(crs_of_wkt("COMPD_CS[\"both\"," + std::string(k_utm_32) + "]"), crs_of_wkt(k_utm_32)),
            same);
}

TEST(CompareCrsTest, heights_of_two_codes_are_different) {
  EXPECT_EQ(compare_crs(crs_of_keys({3072, 32632, 4096, 5773}), crs_of_keys({3072, 32632, 4096, 7837})),
            CrsAgreement::different);
  EXPECT_EQ(compare_crs(crs_of_keys({3072, 32632, 4096, 5773}), crs_of_keys({3072, 32632})),
            CrsAgreement::same);
}

TEST(CompareCrsTest, wkt_without_codes_is_compared_by_letters_and_digits_of_its_names) {
  using enum CrsAgreement;
  EXPECT_EQ(compare_crs(crs_of_wkt(k_esri_32), crs_of_wkt(R"(PROJCS["wgs 1984 UTM zone 32N",DATUM[]])")),
            same);
  EXPECT_EQ(compare_crs(crs_of_wkt(k_esri_32), crs_of_wkt(R"(PROJCS["wgs 1984 UTM zone 33N"])")), different);
  EXPECT_EQ(compare_crs(crs_of_wkt(k_esri_32), crs_of_keys({3072, 32632})), unknown);
  EXPECT_EQ(compare_crs(crs_of_keys({3072, 32767}), crs_of_keys({3072, 32767, 3076, 9001})), different);
}

/// UTM zone 32 as GDAL and as ESRI write it, without codes.
std::string gdal_utm(const std::string& meridian = "9", const std::string& unit = "\"metre\",1") {
  return R"(PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",DATUM["European_Terrestrial_Reference_System_1989",
SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],
PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",)" +
         meridian +
         R"(],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],
UNIT[)" + unit +
         R"(],AXIS["Easting",EAST],AXIS["Northing",NORTH]])";
}
const char* const k_esri_etrs_32 =
    R"(PROJCS["ETRS_1989_UTM_Zone_32N",GEOGCS["GCS_ETRS_1989",DATUM["D_ETRS_1989",
SPHEROID["GRS_1980",6378137.0,298.2572221010001]],PRIMEM["Greenwich",0.0],UNIT["Degree", 0.017453292519943295]],
PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],
PARAMETER["Central_Meridian",9.0],PARAMETER["Scale_Factor",0.9996],PARAMETER["Latitude_Of_Origin",0.0],
UNIT["Meter",1.0]])";

TEST(CompareCrsTest, one_name_or_code_for_other_units_or_numbers_is_no_agreement) {
  using enum CrsAgreement;
  EXPECT_EQ(compare_crs(crs_of_wkt(gdal_utm()), crs_of_wkt(gdal_utm("15"))), different) << "meridian";
  EXPECT_EQ(compare_crs(crs_of_wkt(gdal_utm()), crs_of_wkt(gdal_utm("9", "\"foot\",0.3048"))), different)
      << "unit";
  EXPECT_EQ(compare_crs(crs_of_wkt(gdal_utm()), crs_of_wkt(gdal_utm("9", "\"Meter\",1.0"))), same);
  EXPECT_EQ(compare_crs(crs_of_keys({3072, 2991, 3076, 9001}), crs_of_keys({3072, 2991, 3076, 9002})),
            different);
}

TEST(CompareCrsTest, two_names_for_the_same_numbers_are_not_known_to_differ) {
  using enum CrsAgreement;
  EXPECT_EQ(compare_crs(crs_of_wkt(gdal_utm()), crs_of_wkt(k_esri_etrs_32)), unknown);
  EXPECT_EQ(compare_crs(crs_of_wkt(k_esri_etrs_32), crs_of_wkt("COMPD_CS[\"both\"," + gdal_utm() +
                                                               ",VERT_CS[\"heights\",UNIT[\"metre\",1]]]")),
            unknown);
  EXPECT_EQ(
      compare_crs(crs_of_wkt(k_esri_etrs_32), crs_of_wkt("COMPD_CS[\"both\"," + gdal_utm() +
                                                         ",VERT_CS[\"heights\",UNIT[\"foot\",0.3048]]]")),
      different)
      << "heights of the first are in metres";
  EXPECT_EQ(compare_crs(crs_of_wkt(gdal_utm("15")), crs_of_wkt(k_esri_etrs_32)), different) << "meridian";
  EXPECT_EQ(compare_crs(crs_of_wkt(gdal_utm("9", "\"foot\",0.3048")), crs_of_wkt(k_esri_etrs_32)), different);
  std::string bessel = gdal_utm();
  bessel.replace(bessel.find("6378137,298.257222101"), 21, "6377397.155,299.1528128");
  EXPECT_EQ(compare_crs(crs_of_wkt(bessel), crs_of_wkt(k_esri_etrs_32)), different) << "ellipsoid";
  std::string more = gdal_utm();
  more.insert(more.find("UNIT[\"metre"), "PARAMETER[\"azimuth\",0],");
  EXPECT_EQ(compare_crs(crs_of_wkt(more), crs_of_wkt(k_esri_etrs_32)), different) << "one parameter more";
}

TEST(CompareCrsTest, every_beginning_of_a_wkt_is_compared_without_trouble) {
  const std::string whole = gdal_utm();
  for (std::size_t length = 1; length < whole.size(); ++length) {
    // Of exactly this length, so that the address sanitizer sees every byte read beyond it.
    const std::string part(whole, 0, length);
    EXPECT_NE(compare_crs(crs_of_wkt(part), crs_of_wkt(k_esri_etrs_32)), CrsAgreement::unknown) << length;
    compare_crs(crs_of_wkt(part + "]"), crs_of_wkt(k_esri_etrs_32));
  }
}

TEST(CompareCrsTest, damaged_wkt_is_no_trouble) {
  for (const char* const wkt : {"PROJCS[", "PROJCS[\"", "PROJCS[AUTHORITY[\"EPSG\"", "PROJCS[]]]]",
                                "PROJCS[ID[\"EPSG\",99999999999999999999]]", "[[[[\"EPSG\""})
    EXPECT_NO_THROW(compare_crs(crs_of_wkt(wkt), crs_of_wkt(k_utm_32))) << wkt;
}

/// One point, and a WKT record if it is not empty.
std::vector<std::byte> tile(const std::string& wkt, bool has_point = true) {
  LasFile file;
  if (!wkt.empty()) {
    file.records = {{"LASF_Projection", 2112, "", {wkt.begin(), wkt.end()}}};
    file.records[0].data.push_back(0);
  }
  if (has_point) file.points.emplace_back();
  return build_las(file);
}

PointCloud join(const std::vector<std::vector<std::byte>>& tiles) {
  CloudInputs files;
  for (std::size_t i = 0; i < tiles.size(); ++i)
    files.inputs.push_back(cloud_in_memory(tiles[i], "tile_" + std::to_string(i)));
  return read_cloud(files);
}

TEST(CommonCrsTest, another_system_is_an_error_that_names_the_odd_file_and_both_systems) {
  const std::string message = error_of([] { join({tile(k_utm_32), tile(k_utm_32), tile(k_utm_33)}); });
  EXPECT_EQ(
      message,
      "tile_2: the coordinate reference system differs from that of tile_0; expected WGS 84 / UTM zone 32N "
      "(alidade convert --reproject SYSTEM brings files to one), found WGS 84 / UTM zone 33N");
  EXPECT_TRUE(error_of([] {
                join({tile(k_utm_32), tile(k_utm_33), tile(k_utm_33)});
              }).starts_with("tile_0: the coordinate reference system differs"));
}

TEST(CommonCrsTest, files_without_a_system_give_one_warning) {
  const PointCloud cloud = join({tile(k_utm_32), tile(""), tile(""), tile(k_utm_32)});
  EXPECT_EQ(cloud.crs.wkt, k_utm_32);
  EXPECT_EQ(cloud.warnings,
            (std::vector<std::string>{
                "tile_1 and 1 more file: no coordinate reference system; assuming that of the "
                "other files, WGS 84 / UTM zone 32N"}));
  EXPECT_TRUE(join({tile(""), tile("")}).warnings.empty());
}

TEST(CommonCrsTest, the_system_of_a_file_without_points_binds_nobody) {
  EXPECT_EQ(join({tile(k_utm_33, false), tile(k_utm_32)}).crs.wkt, k_utm_32);
  EXPECT_EQ(join({tile(k_utm_33, false)}).crs.wkt, k_utm_33);
}

TEST(CommonCrsTest, two_names_for_the_same_numbers_are_joined_with_one_warning) {
  const PointCloud cloud = join({tile(gdal_utm()), tile(k_esri_etrs_32), tile(k_esri_etrs_32)});
  EXPECT_EQ(cloud.crs.wkt, gdal_utm());
  EXPECT_EQ(cloud.warnings,
            (std::vector<std::string>{
                "tile_1 and 1 more file: the coordinate reference system is described differently "
                "(ETRS_1989_UTM_Zone_32N) from the other files (ETRS89 / UTM zone 32N), whose "
                "description is kept"}));
}

TEST(CommonCrsTest, systems_that_cannot_be_compared_are_a_warning) {
  LasFile keys;
  keys.points.emplace_back();
  const std::vector<std::uint16_t> directory = {1, 1, 0, 1, 3072, 0, 1, 32632};
  const auto bytes = std::as_bytes(std::span(directory));
  keys.records = {{"LASF_Projection", 34735, "", {}}};
  for (const std::byte byte : bytes) keys.records[0].data.push_back(std::to_integer<std::uint8_t>(byte));
  const PointCloud cloud = join({tile(k_esri_32), build_las(keys)});
  EXPECT_TRUE(warns(cloud, "tile_1: the coordinate reference system is described differently (EPSG:32632)"));
  EXPECT_TRUE(join({tile(k_utm_32), build_las(keys)}).warnings.empty());
}

}  // namespace
}  // namespace alidade
