// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_hours.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "base/error.h"
#include "geo/earth.h"
#include "geo/sun.h"
#include "tests/visibility/sampled_shapes.h"
#include "visibility/sky/sun_path.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

constexpr double k_degree = std::numbers::pi / 180.0;
constexpr double k_latitude = 48.0, k_longitude = 11.0;

SunSchedule schedule(const char* from, const char* to, double step_minutes) {
  SunSchedule range;
  range.from = parse_date_time(from);
  range.to = parse_date_time(to);
  range.step_minutes = step_minutes;
  range.latitude = k_latitude;
  range.longitude = k_longitude;
  return range;
}

double hours_of(std::span<const SunStep> steps) {
  return std::accumulate(steps.begin(), steps.end(), 0.0,
                         [](double sum, const SunStep& step) { return sum + step.hours; });
}

LightOf<SunHours> light_of(std::span<const SunStep> steps, double bin) {
  return sun_light(steps, 1, {.bin = bin});
}

float at(const Occluders& occluders, const SkyTarget& target, const LightOf<SunHours>& light) {
  float hours = 0.0f;
  sun_hours(occluders, std::span(&target, 1), light, {}, std::span(&hours, 1));
  return hours;
}

std::size_t nearest_to(const Points& points, const glm::dvec3& position) {
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (glm::distance(points[i], position) < glm::distance(points[nearest], position)) nearest = i;
  return nearest;
}

SkyTarget open_target(const Occluders& occluders, const Points& points, const glm::dvec3& position) {
  const std::size_t id = nearest_to(points, position);
  std::vector<SkyTarget> target{target_on_point(occluders, id, points[id], {})};
  find_open_sides(occluders, 64, target);
  return target.front();
}

TEST(SunSteps, are_those_in_which_the_sun_is_up) {
  const SunSchedule day = schedule("2026-06-21T00:00Z", "2026-06-22T00:00Z", 5.0);
  const std::vector<SunStep> steps = sun_steps(day);
  // At 48 degrees north, refraction included, of the disc's middle.
  EXPECT_NEAR(hours_of(steps), 15.95, 0.1);
  for (const SunStep& step : steps) {
    EXPECT_GT(step.elevation, 0.0);
    EXPECT_EQ(step.hours, 5.0 / 60.0);
  }
  const SunPosition first = sun_position(parse_date_time("2026-06-21T12:02:30Z"),
                                         {.latitude = k_latitude, .longitude = k_longitude});
  const auto same = std::ranges::find_if(
      steps, [&](const SunStep& step) { return std::fabs(step.azimuth - first.azimuth) < 1e-3; });
  ASSERT_NE(same, steps.end());
  EXPECT_NEAR(same->elevation, first.elevation, 1e-6);
}

TEST(SunSteps, are_turned_to_grid_north_and_cut_at_the_end) {
  SunSchedule hour = schedule("2026-06-21T10:00Z", "2026-06-21T11:00Z", 40.0);
  const std::vector<SunStep> straight = sun_steps(hour);
  ASSERT_EQ(straight.size(), 2u);
  EXPECT_DOUBLE_EQ(straight[0].hours, 40.0 / 60.0);
  EXPECT_DOUBLE_EQ(straight[1].hours, 20.0 / 60.0);
  hour.grid_north = 2.5;
  EXPECT_NEAR(sun_steps(hour)[0].azimuth, straight[0].azimuth - 2.5, 1e-6);
}

TEST(SunSteps, bad_schedules_are_errors) {
  EXPECT_THROW(sun_steps(schedule("2026-06-21T10:00Z", "2026-06-21T10:00Z", 5.0)), Error);
  EXPECT_THROW(sun_steps(schedule("1700-06-21T10:00Z", "2026-06-21T10:00Z", 1.0)), Error);
  for (const double step : {0.0, -1.0, 1441.0, double{NAN}})
    EXPECT_THROW(sun_steps(schedule("2026-06-21T10:00Z", "2026-06-21T11:00Z", step)), Error);
  SunSchedule range = schedule("2026-06-21T10:00Z", "2026-06-21T11:00Z", 5.0);
  range.latitude = 91.0;
  EXPECT_THROW(sun_steps(range), Error);
  range.latitude = 0.0;
  range.height = 20000.0;
  EXPECT_THROW(sun_steps(range), Error);
}

TEST(SunPeriods, are_local_years_months_and_days) {
  SunSchedule schedule;
  schedule.from = parse_date_time("2025-12-31T23:20Z");
  schedule.to = parse_date_time("2026-03-01T23:00Z");
  schedule.longitude = 15.0;
  schedule.latitude = 48.0;
  schedule.step_minutes = 60.0;
  const auto names = [&](SunPeriod period) {
    schedule.period = period;
    return sun_periods(schedule);
  };
  EXPECT_EQ(names(SunPeriod::whole), (std::vector<std::string>{""}));
  EXPECT_EQ(names(SunPeriod::year), (std::vector<std::string>{"2026"}));
  EXPECT_EQ(names(SunPeriod::month), (std::vector<std::string>{"2026-01", "2026-02", "2026-03"}));
  ASSERT_EQ(names(SunPeriod::day).size(), 60u);
  EXPECT_EQ(names(SunPeriod::day).front(), "2026-01-01");
  EXPECT_EQ(names(SunPeriod::day).back(), "2026-03-01");
  schedule.period = SunPeriod::month;
  for (const SunStep& step : sun_steps(schedule)) {
    EXPECT_GE(step.period, 0);
    EXPECT_LE(step.period, 2);
  }
  schedule.to = parse_date_time("2027-03-01T23:00Z");
  EXPECT_THROW(names(SunPeriod::day), Error);
}

TEST(SunSchedule, position_is_given_or_that_of_the_map) {
  SunSchedule range;
  EXPECT_THROW(place_schedule({}, {0, 0}, {}, range), Error);
  EXPECT_FALSE(place_schedule({}, {0, 0}, glm::dvec2(40.0, -105.0), range));
  EXPECT_EQ(range.latitude, 40.0);
  EXPECT_EQ(range.longitude, -105.0);
  EXPECT_EQ(range.grid_north, 0.0);
  Crs utm;
  utm.geotiff_keys = {1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632};
  EXPECT_TRUE(place_schedule(utm, {690000, 5325000}, {}, range));
  EXPECT_NEAR(range.latitude, 48.05, 0.05);
  EXPECT_NEAR(range.longitude, 11.55, 0.05);
  EXPECT_NEAR(range.grid_north, 1.9, 0.1);
}

TEST(SunLight, bins_keep_hours) {
  const std::vector<SunStep> steps = sun_steps(schedule("2026-01-01T00:00Z", "2027-01-01T00:00Z", 30.0));
  const LightOf<SunHours> exact = light_of(steps, 0.0), coarse = light_of(steps, 3.0);
  EXPECT_EQ(exact.bins.size(), steps.size());
  EXPECT_GT(coarse.bins.size(), 600u);
  EXPECT_LT(coarse.bins.size(), 800u);
  SunHours sum;
  for (const auto& bin : coarse.bins) {
    EXPECT_NEAR(glm::length(bin.direction), 1.0, 1e-12);
    for (const auto& share : bin.shares) sum += share.sums;
  }
  EXPECT_NEAR(sum.hours, hours_of(steps), 1e-9);
  EXPECT_NEAR(coarse.open.front().hours, hours_of(steps), 1e-9);
  EXPECT_THROW(light_of(steps, -1.0), Error);
  EXPECT_THROW(light_of(steps, NAN), Error);
}

TEST(SunLight, fans_go_through_the_middles_of_their_sectors) {
  const std::vector<SunStep> steps = {{.azimuth = 31.0, .elevation = 20.0, .hours = 0.5},
                                      {.azimuth = 59.0, .elevation = 25.0, .hours = 0.5}};
  const LightOf<SunHours> light = sun_light(steps, 1, {.bin = 30.0, .by_horizons = true});
  ASSERT_EQ(light.fans.size(), 1u);
  EXPECT_NEAR(light.fans[0].direction.x, std::sqrt(0.5), 1e-12) << "45 degrees";
  EXPECT_NEAR(light.fans[0].direction.y, std::sqrt(0.5), 1e-12);
}

/// A wall from west to east, 0.4 m thick, scanned on both sides and on top.
Points wall() {
  Points points;
  for (const double y : {-0.2, 0.2}) add_rectangle(points, {-15, y, 0}, {30, 0, 0}, {0, 0, 4}, 0.1);
  add_rectangle(points, {-15, -0.2, 4}, {30, 0, 0}, {0, 0.4, 0}, 0.1);
  return points;
}

TEST(SunHours, of_a_walls_north_side_are_those_with_the_sun_in_the_north) {
  const Points points = wall();
  const Occluders occluders(octree_of(points), {});
  const SkyTarget north = open_target(occluders, points, {0, 0.2, 2}),
                  south = open_target(occluders, points, {0, -0.2, 2});
  ASSERT_GT(north.normal.y, 0.999);
  ASSERT_LT(south.normal.y, -0.999);
  for (const auto& [from, to] : {std::pair{"2026-06-21T00:00Z", "2026-06-22T00:00Z"},
                                 std::pair{"2026-12-21T00:00Z", "2026-12-22T00:00Z"}}) {
    const std::vector<SunStep> steps = sun_steps(schedule(from, to, 4.0));
    double hours = 0.0;
    for (const SunStep& step : steps) {
      const double cosine = compass_direction(step.azimuth, step.elevation).y;
      hours += cosine > 0.0 ? step.hours : 0.0;
    }
    const LightOf<SunHours> bins = light_of(steps, 0.0);
    // Points on the wall's edges are spheres, which the sun must pass when it looks along the wall.
    EXPECT_NEAR(at(occluders, north, bins), hours, 0.25) << from;
    EXPECT_NEAR(at(occluders, south, bins), hours_of(steps) - hours, 0.25) << from;
  }
}

TEST(SunHours, of_tilted_receivers_are_those_with_the_sun_before_them) {
  const Occluders occluders(octree_of({{50, 0, 0}}), {.radius = 0.1});
  const SkyTarget target = target_in_open({{0, 0, 1}});
  const std::vector<SunStep> steps = sun_steps(schedule("2026-06-21T00:00Z", "2026-06-22T00:00Z", 4.0));
  double expected = 0.0;
  for (const SunStep& step : steps)
    if (compass_direction(step.azimuth, step.elevation).y > 0.0) expected += step.hours;
  float hours = 0.0f;
  sun_hours(occluders, std::span(&target, 1), light_of(steps, 0.0), {.normal = tilted_normal(90.0, 0.0)},
            std::span(&hours, 1));
  EXPECT_NEAR(hours, expected, 1e-3);
}

TEST(SunHours, in_front_of_a_wall_end_when_its_shadow_comes) {
  // 2 m north of the wall, on the ground: the sun must stand over the wall's top edge, or beside the wall.
  const Points points = wall();
  const Occluders occluders(octree_of(points), {});
  const SkyTarget ground = target_in_open(end_near_surface(occluders, {0, 2.2, 0}));
  const std::vector<SunStep> steps = sun_steps(schedule("2026-03-20T00:00Z", "2026-03-21T00:00Z", 1.0));
  double hours = 0.0;
  for (const SunStep& step : steps) {
    const glm::dvec3 sun = compass_direction(step.azimuth, step.elevation);
    const auto is_shaded = [&](double wall_y, double top) {
      if (!(sun.y < 0.0)) return false;
      const double way = (wall_y - 2.2) / sun.y;
      return std::fabs(way * sun.x) <= 15.0 && way * sun.z <= top;
    };
    // Discs stand over the edge by up to their radius.
    hours += is_shaded(0.2, 4.05) || is_shaded(-0.2, 4.05) ? 0.0 : step.hours;
  }
  EXPECT_GT(hours, 1.0);
  EXPECT_LT(hours, hours_of(steps) - 2.0);
  EXPECT_NEAR(at(occluders, ground, light_of(steps, 0.0)), hours, 0.15);
}

TEST(SunHours, of_a_years_bins_are_near_those_of_its_steps) {
  const Points points = wall();
  const Occluders occluders(octree_of(points), {});
  const std::vector<SunStep> steps = sun_steps(schedule("2026-01-01T00:00Z", "2027-01-01T00:00Z", 20.0));
  for (const double y : {1.0, 3.0, 6.0}) {
    const SkyTarget ground = target_in_open(end_near_surface(occluders, {0, y, 0}));
    const float exact = at(occluders, ground, light_of(steps, 0.0)),
                binned = at(occluders, ground, light_of(steps, 3.0));
    EXPECT_NEAR(binned, exact, 0.02 * hours_of(steps)) << y;
  }
}

}  // namespace
}  // namespace alidade::test
