// SPDX-License-Identifier: MIT
#include "visibility/horizon/skyline_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.h"
#include "image/font.h"
#include "tests/visibility/sampled_shapes.h"
#include "visibility/horizon/horizon.h"
#include "visibility/sky/sun_path.h"

namespace alidade::test {

using namespace image;
using namespace visibility;

namespace {

/// A wall north of the origin, 20 m away, 10 m high.
Points wall() {
  Points points;
  add_rectangle(points, {-10, 20, -1}, {20, 0, 0}, {0, 0, 11}, 0.2);
  return points;
}

std::vector<HorizonDirection> two_directions() {
  std::vector<HorizonDirection> line(3);
  line[0] = {0.0, 12.25, Blocker{7, {690000.125, 5325020.5, 610.0}, 23.4567}};
  line[1].azimuth = 120.0;
  line[2] = {240.0, -1.5, Blocker{8, {689990.0, 5324990.0, 600.0}, 15.0}};
  return line;
}

TEST(DepthPanorama, shows_distances_and_ids_with_north_in_the_middle) {
  const Points points = wall();
  const Occluders occluders(octree_of(points), {});
  const Film film = depth_panorama(occluders, {}, 64, 32);
  const std::size_t north = film.index(32, 15), south = film.index(0, 15);
  EXPECT_NEAR(film.distance[north], 20.0, 0.1);
  EXPECT_EQ(film.depth[north], film.distance[north]);
  ASSERT_GT(film.id[north], 0u);
  EXPECT_NEAR(glm::distance(points[film.id[north] - 1], glm::dvec3(0.98, 20, 0.98)), 0.0, 0.5);
  EXPECT_EQ(film.distance[south], std::numeric_limits<float>::infinity());
  EXPECT_EQ(film.id[south], 0u);
  EXPECT_TRUE(film.color.empty());
  EXPECT_EQ(depth_panorama(occluders, {}, 64, 32, 19.0).id[north], 0u);
}

TEST(DepthStrip, holds_the_line_with_room_around) {
  DepthStrip strip = strip_around(two_directions(), 0.0, 360.0);
  EXPECT_LE(strip.elevation_min, -4.5);
  EXPECT_GE(strip.elevation_max, 15.25);
  EXPECT_EQ(strip.width, 1440);
  strip = strip_around({}, 0.0, 360.0);
  EXPECT_GE(strip.elevation_max - strip.elevation_min, 20.0);
}

TEST(DepthStrip, looks_in_the_directions_of_its_rows_and_columns) {
  const Occluders occluders(octree_of(wall()), {});
  DepthStrip strip;
  strip.width = 36;
  strip.height = 10;
  strip.elevation_min = 0.0;
  strip.elevation_max = 50.0;
  fill_strip(occluders, {}, std::numeric_limits<double>::infinity(), strip);
  const auto at = [&](int x, int y) { return strip.distances[static_cast<std::size_t>(36 * y + x)]; };
  EXPECT_TRUE(std::isfinite(at(0, 9)));
  EXPECT_TRUE(std::isfinite(at(35, 9)));
  EXPECT_TRUE(std::isfinite(at(0, 5))) << "22.5 degrees up, below the edge at 26";
  EXPECT_FALSE(std::isfinite(at(0, 4))) << "27.5 degrees up";
  EXPECT_FALSE(std::isfinite(at(9, 9))) << "east";
}

TEST(SkylineImage, draws_sky_things_and_the_line) {
  std::error_code error;
  if (!std::filesystem::exists(font_files().front(), error)) GTEST_SKIP() << "no DejaVu Sans";
  const Occluders occluders(octree_of(wall()), {});
  const std::vector<HorizonDirection> line = horizon(occluders, {}, {});
  DepthStrip strip = strip_around(line, 0.0, 360.0);
  fill_strip(occluders, {}, std::numeric_limits<double>::infinity(), strip);
  const Canvas canvas = draw_skyline(strip, line, {"Skyline", "a note", "m"}, Font(find_font()));
  EXPECT_GT(canvas.width(), strip.width);
  EXPECT_GT(canvas.height(), strip.height);
  int red = 0, sky = 0;
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) {
      red += canvas.at(x, y) == Rgb8{205, 30, 45};
      sky += canvas.at(x, y) == Rgb8{232, 241, 250};
    }
  }
  EXPECT_GT(red, 200) << "the line over the wall";
  EXPECT_GT(sky, strip.width * strip.height / 2);
}

TEST(Skyline, curves_are_bright_over_the_sky_and_faint_over_what_hides_them) {
  constexpr Rgb8 k_color{200, 10, 240};
  DepthStrip strip;
  strip.width = 720;
  strip.height = 320;
  strip.distances.assign(720 * 320, std::numeric_limits<float>::infinity());
  for (int y = 0; y < 320; ++y) std::fill_n(strip.distances.begin() + y * 720, 360, 10.0f);
  SkylineTexts texts;
  texts.curves.push_back({.positions = {{350, 45}, {10, 45}, {350, 45}}, .color = k_color});
  const auto count_of = [&](const Canvas& canvas, const auto& counts) {
    int count = 0;
    for (int y = 0; y < canvas.height(); ++y)
      for (int x = 0; x < canvas.width(); ++x) count += counts(x, canvas.at(x, y));
    return count;
  };
  const auto is_curve = [&](int, const Rgb8& color) { return color == k_color; };
  EXPECT_EQ(count_of(draw_skyline(strip, {}, texts, Font(find_font())), is_curve), 0)
      << "north is passed, not crossed";
  texts.curves.front().positions = {{10, 45}, {180, 45}, {350, 45}};
  texts.curves.front().marks = {{{270, 45}, "12"}};
  const Canvas canvas = draw_skyline(strip, {}, texts, Font(find_font()));
  const int bright = count_of(canvas, is_curve);
  EXPECT_GT(bright, 300) << "half of the line, about 340 pixels";
  EXPECT_LT(bright, 1000);
  strip.distances.assign(720 * 320, 10.0f);
  EXPECT_EQ(count_of(draw_skyline(strip, {}, texts, Font(find_font())), is_curve), 0);
}

TEST(SunCurves, are_the_paths_of_solstices_and_equinox_with_hours_of_mean_solar_time) {
  SunSchedule schedule;
  schedule.from = parse_date_time("2026-05-05T00:00Z");
  schedule.to = parse_date_time("2026-05-06T00:00Z");
  schedule.latitude = 48.0;
  schedule.longitude = 11.0;
  const std::vector<SkylineCurve> curves = sun_curves(schedule);
  ASSERT_GT(curves.size(), 3u);
  const std::span<const SkylineCurve> days = std::span(curves).last(3);
  const double tilt = 23.44;
  for (const auto& [curve, noon] :
       {std::pair{&days[0], 42.0 + tilt}, {&days[1], 42.0}, {&days[2], 42.0 - tilt}}) {
    double highest = 0.0;
    for (const glm::dvec2& position : curve->positions) highest = std::max(highest, position.y);
    EXPECT_NEAR(highest, noon, 0.3) << curve->label;
  }
  EXPECT_EQ(days[0].label, "21 June");
  EXPECT_EQ(days[0].marks.size(), 16u) << "from 4 to 19";
  const auto noon = std::ranges::find(days[0].marks, "12", &SkylineCurve::Mark::label);
  ASSERT_NE(noon, days[0].marks.end());
  // The equation of time is below two minutes then.
  EXPECT_NEAR(noon->position.x, 180.0, 1.5);
  const auto lines = static_cast<int>(curves.size()) - 3;
  EXPECT_EQ(lines, 16) << "an hour each that has sun in summer";
  for (const SkylineCurve& line : std::span(curves).first(16)) EXPECT_TRUE(line.label.empty());
}

TEST(HorizonFile, csv_has_a_row_per_azimuth) {
  std::vector<HorizonDirection> line = two_directions();
  line[2].unscanned = 4.5;
  EXPECT_EQ(horizon_csv(line),
            "azimuth,elevation,distance,point_id,x,y,z,unscanned\n"
            "0,12.25,23.4567,7,690000.125,5325020.5,610,\n"
            "120,,,,,,,\n"
            "240,-1.5,15.0000,8,689990,5324990,600,4.5000\n");
}

TEST(HorizonFile, geojson_has_points_on_the_globe_or_reports_that_they_are_not) {
  const std::vector<HorizonDirection> line = two_directions();
  HorizonFacts facts{{690000, 5325000, 601.7}, SkyShares{0.5, 0.4}, {0.6, 0.55}};
  ASSERT_EQ(horizon_positions(line, facts).size(), 3u);
  const auto flat = nlohmann::json::parse(horizon_geojson(line, facts, {}));
  EXPECT_EQ(flat["type"], "FeatureCollection");
  EXPECT_TRUE(flat.contains("coordinate_system"));
  ASSERT_EQ(flat["features"].size(), 4u);
  const auto& eye = flat["features"][0];
  EXPECT_EQ(eye["properties"]["kind"], "observer");
  EXPECT_EQ(eye["geometry"]["coordinates"][1], 5325000.0);
  EXPECT_EQ(eye["properties"]["sky_view_factor"], 0.6);
  EXPECT_EQ(eye["properties"]["sky_view_factor_above_line"], 0.5);
  const auto& first = flat["features"][1];
  EXPECT_EQ(first["geometry"]["coordinates"][0], 690000.125);
  EXPECT_EQ(first["properties"]["elevation"], 12.25);
  EXPECT_EQ(first["properties"]["point_id"], 7);
  EXPECT_TRUE(flat["features"][2]["geometry"].is_null());
  facts.above_line.reset();
  const auto globe = nlohmann::json::parse(horizon_geojson(
      line, facts, std::vector<glm::dvec3>{{11.5, 48.0, 0.0}, {11.6, 48.1, 0.0}, {11.7, 48.2, 0.0}}));
  EXPECT_FALSE(globe.contains("coordinate_system"));
  EXPECT_FALSE(globe["features"][0]["properties"].contains("sky_view_factor_above_line"));
  EXPECT_EQ(globe["features"][0]["geometry"]["coordinates"][0], 11.7);
  EXPECT_EQ(globe["features"][3]["geometry"]["coordinates"][1], 48.1);
}

}  // namespace
}  // namespace alidade::test
