// SPDX-License-Identifier: MIT
#include "cloud/crs.h"

#include <gtest/gtest.h>

#include "tests/cloud/crs_of_keys.h"

namespace alidade {
namespace {

constexpr const char* k_degrees = R"(GEOGCS["WGS 84",DATUM["WGS_1984"],UNIT["degree",0.0174532925199433]])";

Bounds box(double x, double y) {
  Bounds bounds;
  bounds.min = {x - 0.01, y - 0.01, -5000.0};
  bounds.max = {x + 0.01, y + 0.01, 9000.0};
  return bounds;
}

Crs keys(std::uint16_t model) {
  return test::crs_of_keys({1024, model, 2048, 4326});
}

TEST(CrsPlausibility, a_geographic_system_differs_from_a_projected_one) {
  EXPECT_TRUE(is_geographic(crs_of_wkt(k_degrees)));
  EXPECT_TRUE(is_geographic(crs_of_wkt(R"(GEOGCRS["WGS 84",DATUM["World Geodetic System 1984"]])")));
  EXPECT_TRUE(is_geographic(crs_of_wkt(std::string(R"(COMPD_CS["with heights",)") + k_degrees + "]")));
  EXPECT_FALSE(is_geographic(crs_of_wkt(std::string(R"(PROJCS["UTM zone 32N",)") + k_degrees + "]")));
  EXPECT_FALSE(is_geographic(crs_of_wkt(R"(LOCAL_CS["site"])")));
  EXPECT_TRUE(is_geographic(keys(2)));
  EXPECT_FALSE(is_geographic(keys(1)));
  EXPECT_FALSE(is_geographic(Crs{}));

  EXPECT_TRUE(is_geographic(test::crs_of_keys({2048, 4326}))) << "without model";
  EXPECT_FALSE(is_geographic(test::crs_of_keys({2048, 4326, 3072, 32632})));
}

TEST(CrsPlausibility, geodetic_systems_are_detected_by_their_coordinates) {
  const Crs angles = crs_of_wkt(R"(GEODCRS["WGS 84",DATUM["World Geodetic System 1984"],CS[ellipsoidal,2]])");
  const Crs lengths = crs_of_wkt(R"(GEODCRS["WGS 84",DATUM["World Geodetic System 1984"],CS[Cartesian,3]])");
  const Crs utm = crs_of_wkt(R"(PROJCRS["UTM",BASEGEODCRS["WGS 84",DATUM["WGS 1984"]],CS[Cartesian,2]])");
  EXPECT_TRUE(is_geographic(angles));
  EXPECT_FALSE(is_geocentric(angles));
  EXPECT_TRUE(is_geocentric(lengths));
  EXPECT_FALSE(is_geographic(lengths));
  EXPECT_FALSE(is_geographic(utm) || is_geocentric(utm));
}

TEST(CrsPlausibility, wkt_decides_where_geotiff_keys_differ) {
  Crs both = keys(2);
  both.wkt = R"(PROJCS["UTM zone 32N"])";
  EXPECT_FALSE(is_geographic(both));
}

TEST(CrsPlausibility, degrees_where_coordinates_are_no_angles_give_a_warning) {
  const auto said = implausible_crs(crs_of_wkt(k_degrees), box(515368.0, 4918340.0));
  ASSERT_TRUE(said);
  EXPECT_NE(said->find("not an angle"), std::string::npos);
  EXPECT_TRUE(implausible_crs(crs_of_wkt(k_degrees), box(10.0, 4918340.0)));
}

TEST(CrsPlausibility, geocentric_points_lie_at_the_surface_of_the_earth) {
  Bounds at_vienna = box(4085700.0, 1201000.0);
  at_vienna.min.z = 4732000.0;
  at_vienna.max.z = 4732100.0;
  for (const Crs& crs : {keys(3), crs_of_wkt(R"(GEOCCS["WGS 84 geocentric",DATUM["WGS_1984"]])")}) {
    EXPECT_TRUE(is_geocentric(crs));
    EXPECT_FALSE(is_geographic(crs));
    EXPECT_FALSE(implausible_crs(crs, at_vienna));
    EXPECT_TRUE(implausible_crs(crs, box(515368.0, 4918340.0)));
  }
  EXPECT_FALSE(is_geocentric(keys(2)));
  EXPECT_FALSE(is_geocentric(crs_of_wkt(k_degrees)));
}

TEST(CrsPlausibility, angles_and_projected_coordinates_are_not_wrong) {
  EXPECT_FALSE(implausible_crs(crs_of_wkt(k_degrees), box(-94.67, 31.04)));
  EXPECT_FALSE(implausible_crs(keys(1), box(515368.0, 4918340.0)));
  EXPECT_FALSE(implausible_crs(Crs{}, box(515368.0, 4918340.0)));
  EXPECT_FALSE(implausible_crs(crs_of_wkt(k_degrees), Bounds{}));
}

}  // namespace
}  // namespace alidade
