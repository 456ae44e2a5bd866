// SPDX-License-Identifier: MIT
#include "geo/sun.h"

#include <cpl_conv.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "geo/earth.h"

namespace alidade::test {

using namespace geo;

namespace {

Crs epsg(int code) {
  const OGRSpatialReferenceH reference = OSRNewSpatialReference(nullptr);
  EXPECT_EQ(OSRImportFromEPSG(reference, code), OGRERR_NONE);
  char* wkt = nullptr;
  OSRExportToWkt(reference, &wkt);
  Crs crs;
  crs.wkt = wkt;
  CPLFree(wkt);
  OSRDestroySpatialReference(reference);
  return crs;
}

SunByTime noon(const char* date_time) {
  return {.moment = parse_date_time(date_time)};
}

TEST(GroundPosition, of_a_utm_map_is_turned_by_the_convergence_of_the_meridians) {
  // Transverse Mercator of a sphere: tan(convergence) = tan(longitude - that of the middle) sin(latitude); on
  // the ellipsoid the same within 0.001 degrees so near the middle.
  for (const auto& [x, y] : {std::pair{690000.0, 5325000.0}, {310000.0, 5325000.0}, {690000.0, 100000.0}}) {
    const auto position = ground_position(epsg(32632), {x, y});
    ASSERT_TRUE(position);
    const double radian = std::numbers::pi / 180.0;
    const double expected =
        std::atan(std::tan((position->longitude - 9.0) * radian) * std::sin(position->latitude * radian)) /
        radian;
    EXPECT_NEAR(position->grid_north, expected, 1e-3) << x << " " << y;
  }
  const auto munich = ground_position(epsg(32632), {690000.0, 5325000.0});
  EXPECT_NEAR(munich->latitude, 48.05, 0.05);
  EXPECT_NEAR(munich->longitude, 11.55, 0.05);
  EXPECT_GT(munich->grid_north, 1.8);  // grid north points east of true north, east of the middle meridian
}

TEST(GroundPosition, of_a_conic_map_is_turned_by_the_cone_times_the_longitude) {
  // Lambert-93 (IGN): n = 0.7256077650, middle meridian 3 degrees east.
  for (const double x : {200000.0, 700000.0, 1100000.0}) {
    const auto position = ground_position(epsg(2154), {x, 6600000.0});
    ASSERT_TRUE(position);
    EXPECT_NEAR(position->grid_north, 0.7256077650 * (position->longitude - 3.0), 1e-5) << x;
  }
}

TEST(GroundPosition, of_a_polar_map_is_turned_by_the_longitude_itself) {
  // Antarctic polar stereographic: true north is away from the pole in the middle.
  const auto position = ground_position(epsg(3031), {1e6, 1e6});
  ASSERT_TRUE(position);
  EXPECT_NEAR(position->longitude, 45.0, 1e-6);
  EXPECT_LT(position->latitude, -70.0);
  EXPECT_NEAR(position->grid_north, -45.0, 1e-5);
}

TEST(GroundPosition, of_degrees_and_of_a_map_with_heights_is_the_position_itself) {
  const auto degrees = ground_position(epsg(4326), {11.5, 48.0});
  ASSERT_TRUE(degrees);
  EXPECT_NEAR(degrees->longitude, 11.5, 1e-9);
  EXPECT_NEAR(degrees->latitude, 48.0, 1e-9);
  EXPECT_EQ(degrees->grid_north, 0.0);
  // ETRS89 / UTM 32 with German heights.
  const auto with_heights = ground_position(epsg(5555), {690000.0, 5325000.0});
  const auto without = ground_position(epsg(25832), {690000.0, 5325000.0});
  ASSERT_TRUE(with_heights && without);
  EXPECT_NEAR(with_heights->latitude, without->latitude, 1e-9);
  EXPECT_NEAR(with_heights->grid_north, without->grid_north, 1e-9);
}

TEST(GroundPosition, is_empty_without_a_position_on_earth) {
  EXPECT_FALSE(ground_position(Crs(), {0, 0}));
  Crs nonsense;
  nonsense.wkt = "no reference system";
  EXPECT_FALSE(ground_position(nonsense, {0, 0}));
  Crs local;
  local.wkt = R"(LOCAL_CS["site",UNIT["metre",1]])";
  EXPECT_FALSE(ground_position(local, {0, 0}));
  EXPECT_FALSE(ground_position(epsg(4978), {4e6, 8e5}));  // geocentric
  EXPECT_FALSE(ground_position(epsg(32632), {1e30, NAN}));
  EXPECT_FALSE(ground_position(epsg(4326), {11.5, 480.0}));
}

TEST(PlaceSun, stands_by_grid_north_in_a_map_and_by_true_north_without_one) {
  SunByTime by_time = noon("2024-06-20T12:00+01:00");
  const std::optional<SceneMap> map = SceneMap{epsg(32632), {690000.0, 5325000.0}};
  const PlacedSun on_map = place_sun(by_time, map);
  EXPECT_TRUE(on_map.is_up && on_map.is_map_known);
  EXPECT_NEAR(on_map.sun.azimuth, on_map.true_azimuth - on_map.grid_north, 1e-5);
  EXPECT_GT(on_map.grid_north, 1.8);
  by_time.latitude = on_map.latitude;
  by_time.longitude = on_map.longitude;
  const PlacedSun without = place_sun(by_time, std::nullopt);
  EXPECT_FALSE(without.is_map_known);
  EXPECT_EQ(without.sun.azimuth, without.true_azimuth);
  EXPECT_EQ(without.true_azimuth, on_map.true_azimuth);
  EXPECT_EQ(without.sun.elevation, on_map.sun.elevation);
  // Coordinates of its own move the sun, but the map keeps its grid north.
  by_time.longitude = 0.0;
  const PlacedSun elsewhere = place_sun(by_time, map);
  EXPECT_EQ(elsewhere.grid_north, on_map.grid_north);
  EXPECT_LT(elsewhere.true_azimuth, on_map.true_azimuth - 10.0);
}

TEST(PlaceSun, is_as_bright_as_under_a_clear_sky_or_as_given) {
  SunByTime by_time = noon("2024-06-20T12:00Z");
  by_time.latitude = 23.4;
  by_time.longitude = 0.0;
  const Rgb overhead = place_sun(by_time, std::nullopt).sun.irradiance;
  EXPECT_NEAR(overhead.g, 3.26, 0.05);  // 4 exp(-0.206)
  by_time.latitude = 80.0;
  EXPECT_LT(place_sun(by_time, std::nullopt).sun.irradiance.g, overhead.g);
  by_time.irradiance = Rgb(1.0f, 2.0f, 3.0f);
  by_time.angular_diameter = 2.0;
  EXPECT_EQ(place_sun(by_time, std::nullopt).sun.irradiance, Rgb(1.0f, 2.0f, 3.0f));
  EXPECT_EQ(place_sun(by_time, std::nullopt).sun.angular_diameter, 2.0);
}

TEST(PlaceSun, is_down_at_night) {
  SunByTime by_time = noon("2024-12-21T00:00Z");
  by_time.latitude = 48.0;
  by_time.longitude = 11.5;
  const PlacedSun placed = place_sun(by_time, std::nullopt);
  EXPECT_FALSE(placed.is_up);
  EXPECT_LT(placed.sun.elevation, -60.0);
  EXPECT_EQ(placed.sun.irradiance, Rgb(0.0f));
}

TEST(PlaceSun, needs_a_position_from_somewhere) {
  const auto message = [](const std::optional<SceneMap>& map) -> std::string {
    try {
      place_sun(noon("2024-06-20T12:00Z"), map);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_TRUE(message(std::nullopt).ends_with("found no cloud")) << message(std::nullopt);
  EXPECT_TRUE(message(SceneMap{}).ends_with("found a cloud without a reference system"));
  EXPECT_TRUE(message(SceneMap{epsg(4978), {4e6, 8e5}})
                  .ends_with("found a reference system without a location on Earth"));
}

TEST(PlaceSun, describes_itself_in_one_line) {
  SunByTime by_time = noon("2003-10-17T12:30:30-07:00");
  by_time.latitude = 39.742476;
  by_time.longitude = -105.1786;
  by_time.height = 1830.14;
  by_time.pressure = 820;
  by_time.temperature = 11;
  const std::string line = describe(by_time, place_sun(by_time, std::nullopt));
  EXPECT_TRUE(line.starts_with("sun at azimuth 194.340")) << line;
  EXPECT_NE(line.find(" (+y assumed to be true north), elevation 39.888"), std::string::npos) << line;
  EXPECT_TRUE(line.ends_with("degrees, 2003-10-17T19:30:30Z at latitude 39.742476, longitude -105.178600"))
      << line;
}

}  // namespace
}  // namespace alidade::test
