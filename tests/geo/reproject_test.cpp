// SPDX-License-Identifier: MIT
#include "geo/reproject.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/error.h"

namespace alidade::geo {
namespace {

FileFacts facts_of(const std::string& system) {
  FileFacts facts;
  if (!system.empty()) facts.crs = crs_of_text(system);
  return facts;
}

std::string problem_of(const ReferenceRequest& request, const FileFacts& facts) {
  try {
    change_reference(request, "site.las", facts);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ReprojectTest, positions_move_as_the_published_example_says) {
  // Source: EPSG guidance note 7-2, Transverse Mercator: 50 30' N, 0 30' E, on OSGB 1936, is E 577274.99,
  // N 69740.50.
  const ReferenceChange change =
      change_reference({.wanted = "EPSG:27700"}, "site.las", facts_of("EPSG:4277"));
  ASSERT_TRUE(change.move);
  std::vector<glm::dvec3> positions(10'000, {0.5, 50.5, 12.5});
  change.move(positions);
  for (const glm::dvec3& position : {positions.front(), positions.back()}) {
    EXPECT_NEAR(position.x, 577274.99, 0.01);
    EXPECT_NEAR(position.y, 69740.50, 0.01);
    EXPECT_EQ(position.z, 12.5);
  }
}

TEST(ReprojectTest, geocentric_positions_get_ellipsoidal_heights) {
  // On the equator at longitude 9: a hundred metres above the ellipsoid of WGS 84, the middle of zone 32.
  const double radius = 6378137.0 + 100.0, angle = 9.0 / 180.0 * M_PI;
  const FileFacts facts = facts_of("EPSG:4978");
  std::vector<glm::dvec3> positions = {{radius * std::cos(angle), radius * std::sin(angle), 0.0}};
  EXPECT_EQ(metric_system(facts.crs, positions[0], "site.las"), "EPSG:32632");
  change_reference({.wanted = "EPSG:32632"}, "site.las", facts).move(positions);
  EXPECT_NEAR(positions[0].x, 500000.0, 1e-3);
  EXPECT_NEAR(positions[0].y, 0.0, 1e-3);
  EXPECT_NEAR(positions[0].z, 100.0, 1e-3);
}

TEST(ReprojectTest, a_position_without_image_becomes_not_finite) {
  const ReferenceChange change = change_reference({.wanted = "EPSG:3857"}, "site.las", facts_of("EPSG:4326"));
  std::vector<glm::dvec3> positions = {{9, 50, 1}, {9, 1000, 1}};
  change.move(positions);
  EXPECT_TRUE(std::isfinite(positions[0].x));
  EXPECT_FALSE(std::isfinite(positions[1].x));
}

TEST(ReprojectTest, the_same_system_moves_nothing) {
  EXPECT_FALSE(change_reference({.wanted = "EPSG:25832"}, "site.las", facts_of("EPSG:25832")).move);
}

TEST(ReprojectTest, heights_of_a_compound_system_keep_their_name) {
  const ReferenceChange change =
      change_reference({.wanted = "EPSG:4258"}, "site.las", facts_of("EPSG:25832+7837"));
  EXPECT_NE(change.crs.wkt.find("VERT_CS[\"DHHN2016 height\""), std::string::npos) << change.crs.wkt;
  EXPECT_NE(change.crs.wkt.find("GEOGCS[\"ETRS89\""), std::string::npos) << change.crs.wkt;
}

/// What becomes of a height in a system when it gets into another one, and the unit it is in afterwards.
std::string height_in(const std::string& wanted, const std::string& own,
                      const ReferenceRequest& request = {}) {
  ReferenceRequest all = request;
  all.wanted = wanted;
  const ReferenceChange change = change_reference(all, "site.las", facts_of(own));
  std::vector<glm::dvec3> positions = {{500000, 200000, 1000 * change.height_factor}};
  if (change.move) change.move(positions);
  const AxisUnits units = stated_units(change.crs);
  const std::optional<LengthUnit> unit = units.heights ? units.heights : units.plane;
  return fmt::format("{:.3f} {}", positions[0].z, unit ? short_name(*unit) : "-");
}

TEST(ReprojectTest, heights_get_the_unit_of_the_wanted_system) {
  EXPECT_EQ(height_in("EPSG:26910", "EPSG:2991"), "1000.000 m");
  EXPECT_EQ(height_in("EPSG:26910", "EPSG:2994"), "304.800 m")
      << "in the unit of x and y, as nothing else is stated";
  EXPECT_EQ(height_in("EPSG:26910", "EPSG:2994+6360"), "304.801 m");
  EXPECT_EQ(height_in("EPSG:26910", "EPSG:2994+5703"), "1000.000 m");
  EXPECT_EQ(height_in("EPSG:26910", "EPSG:2991+6360"), "304.801 m");
  EXPECT_EQ(height_in("EPSG:2994", "EPSG:2991"), "3280.840 ft");
  EXPECT_EQ(height_in("EPSG:2994", "EPSG:2991+5703"), "3280.840 ft");
  EXPECT_EQ(height_in("EPSG:26910+5703", "EPSG:2994"), "304.800 m");
  EXPECT_EQ(height_in("EPSG:26910+6360", "EPSG:2991"), "3280.833 us-ft");
  EXPECT_EQ(height_in("EPSG:26910+5703", "EPSG:2991+6360"), "304.801 m") << "by PROJ";
  EXPECT_EQ(height_in("EPSG:26910+6360", "EPSG:2991+5703"), "3280.833 us-ft") << "by PROJ";
  EXPECT_EQ(height_in("EPSG:26910+6360", "EPSG:2991+5703", {.has_one_unit = true}), "1000.000 m");
  EXPECT_EQ(height_in("EPSG:4152", "EPSG:2994"), "304.800 -") << "over degrees metres";
  EXPECT_EQ(height_in("EPSG:26910", "EPSG:2991", {.height_unit = k_foot}), "304.800 m");
  EXPECT_EQ(height_in("EPSG:26910", "EPSG:2994", {.height_unit = k_metre}), "1000.000 m");
}

TEST(ReprojectTest, heights_above_the_ellipsoid_are_converted_once) {
  const auto height = [](const std::string& wanted, const std::string& own, const glm::dvec3& position) {
    const ReferenceChange change = change_reference({.wanted = wanted}, "site.las", facts_of(own));
    std::vector<glm::dvec3> positions = {{position.x, position.y, position.z * change.height_factor}};
    change.move(positions);
    return positions[0].z;
  };
  // The geoid is some 20 m below the ellipsoid there, where PROJ has it.
  EXPECT_NEAR(height("EPSG:2994+6360", "EPSG:4979", {-123, 44.5, 1000}), 3281.0, 100.0);
  EXPECT_NEAR(height("EPSG:4979", "EPSG:2994+6360", {500000, 900000, 3281}), 1000.0, 30.0);
  EXPECT_NEAR(height("EPSG:2994", "EPSG:4979", {-123, 44.5, 1000}), 1000.0 / 0.3048, 1e-6);
}

TEST(ReprojectTest, heights_alone_change_on_the_lattice) {
  const ReferenceChange change =
      change_reference({.wanted = "EPSG:2991"}, "site.las", facts_of("EPSG:2991+6360"));
  EXPECT_FALSE(change.move);
  EXPECT_EQ(change.height_factor, 1200.0 / 3937.0);
  EXPECT_EQ(change.heights_note, "heights are converted from US survey foot to metre");
  EXPECT_EQ(change_reference({.wanted = "EPSG:26910"}, "site.las", facts_of("EPSG:2994")).heights_note,
            "heights are converted from foot to metre, as if in the unit of x and y; --vertical-unit states "
            "another");
  EXPECT_EQ(change_reference({.wanted = "EPSG:2994"}, "site.las", facts_of("EPSG:4326")).heights_note,
            "heights are converted from metre to foot, as if in metres; --vertical-unit states "
            "another");
  EXPECT_EQ(change_reference({.wanted = "EPSG:26910"}, "site.las", facts_of("EPSG:2991")).heights_note, "");
}

TEST(ReprojectTest, geocentric_positions_get_heights_in_the_wanted_unit) {
  const double radius = 6378137.0 + 100.0, angle = -123.0 / 180.0 * M_PI;
  std::vector<glm::dvec3> positions = {{radius * std::cos(angle), radius * std::sin(angle), 0.0}};
  const ReferenceChange change = change_reference({.wanted = "EPSG:2994"}, "site.las", facts_of("EPSG:4978"));
  EXPECT_EQ(change.height_factor, 1.0);
  change.move(positions);
  EXPECT_NEAR(positions[0].z, 100.0 / 0.3048, 1e-2);
}

TEST(ReprojectTest, heights_of_a_system_of_the_file_alone_have_no_unit_until_it_is_stated) {
  // Oregon in feet, and a vertical system that a program defined without a unit: GDAL takes it for metres.
  FileFacts facts;
  facts.crs.geotiff_keys = {1, 1, 0, 3, 1024, 0, 1, 1, 3072, 0, 1, 2994, 4096, 0, 1, 32767};
  EXPECT_NE(problem_of({.wanted = "EPSG:26910"}, facts).find("the unit of heights is unknown"),
            std::string::npos);
  EXPECT_EQ(
      change_reference({.wanted = "EPSG:26910", .height_unit = k_foot}, "site.las", facts).height_factor,
      0.3048);
}

TEST(ReprojectTest, a_stated_unit_of_heights_must_not_contradict_the_file) {
  EXPECT_NE(problem_of({.wanted = "EPSG:26910", .height_unit = k_metre}, facts_of("EPSG:2991+6360"))
                .find("--vertical-unit contradicts the reference system of the file"),
            std::string::npos);
}

TEST(ReprojectTest, a_system_can_be_stated_with_a_warning_where_the_file_says_another) {
  EXPECT_TRUE(change_reference({.stated = "EPSG:25832"}, "site.las", {}).warnings.empty());
  EXPECT_TRUE(
      change_reference({.stated = "EPSG:25832"}, "site.las", facts_of("EPSG:25832")).warnings.empty());
  const ReferenceChange change =
      change_reference({.stated = "EPSG:25832"}, "site.las", facts_of("EPSG:31468"));
  EXPECT_FALSE(change.move);
  EXPECT_EQ(epsg_codes(change.crs), epsg_codes(crs_of_text("EPSG:25832")));
  ASSERT_EQ(change.warnings.size(), 1u);
  EXPECT_EQ(
      change.warnings[0],
      "site.las: the file states the reference system DHDN / 3-degree Gauss-Kruger zone 4; ETRS89 / UTM zone "
      "32N is used instead");
}

TEST(ReprojectTest, zones_are_those_of_utm_and_near_the_poles_of_ups) {
  const Crs globe = crs_of_text("EPSG:4326");
  const auto zone = [&](double x, double y) { return metric_system(globe, {x, y, 0.0}, "site.las"); };
  EXPECT_EQ(zone(-180, 10), "EPSG:32601");
  EXPECT_EQ(zone(180, -10), "EPSG:32760");
  EXPECT_EQ(zone(11.99, 48), "EPSG:32632");
  EXPECT_EQ(zone(12, 48), "EPSG:32633");
  EXPECT_EQ(zone(0, 85), "EPSG:5041");
  EXPECT_EQ(zone(0, -85), "EPSG:5042");
  EXPECT_EQ(metric_system(crs_of_text("EPSG:25832"), {690000, 5325000, 0}, "site.las"), "");
}

TEST(ReprojectTest, errors_name_the_file_and_the_way_out) {
  EXPECT_EQ(
      problem_of({.wanted = "EPSG:25832"}, {}),
      "site.las: cannot reproject: the reference system is unknown; expected --crs EPSG:n, which states it");
  EXPECT_EQ(problem_of({.wanted = "nonsense"}, facts_of("EPSG:25832")),
            "unknown reference system; expected a reference system such as EPSG:25832, found 'nonsense'");
  FileFacts metres = facts_of("EPSG:4326");
  metres.box = Bounds{{515368, 4918340, 2300}, {515401, 4918381, 2330}};
  EXPECT_NE(problem_of({.wanted = "EPSG:32632"}, metres).find("is not an angle"), std::string::npos);
}

}  // namespace
}  // namespace alidade::geo
