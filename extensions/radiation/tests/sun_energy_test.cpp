// SPDX-License-Identifier: MIT
#include "extensions/radiation/radiation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "base/error.h"
#include "geo/earth.h"
#include "geo/sun.h"
#include "tests/visibility/sampled_shapes.h"

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

double hours_of(std::span<const LitStep> steps) {
  return std::accumulate(steps.begin(), steps.end(), 0.0,
                         [](double sum, const LitStep& step) { return sum + step.hours; });
}

/// The sun alone.
EnergyLight beam_light(std::span<const LitStep> steps, double bin) {
  return energy_light(steps, 1, {.bin = bin, .has_sky = false});
}

Radiation at(const Occluders& occluders, const SkyTarget& target, const EnergyLight& light,
             SkyReceiver receiver = SkyReceiver::surface) {
  Radiation answer;
  radiation(occluders, std::span(&target, 1), light, {.receiver = receiver}, std::span(&answer, 1));
  return answer;
}

std::vector<LitStep> lit(const SunSchedule& range) {
  return lit_steps(range, sun_steps(range), {});
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

TEST(EnergyLight, bins_keep_hours_and_energy) {
  const std::vector<LitStep> steps = lit(schedule("2026-01-01T00:00Z", "2027-01-01T00:00Z", 30.0));
  const EnergyLight exact = beam_light(steps, 0.0), coarse = beam_light(steps, 3.0);
  EXPECT_EQ(exact.bins.size(), steps.size());
  EXPECT_GT(coarse.bins.size(), 600u);
  EXPECT_LT(coarse.bins.size(), 800u);
  const auto sum_of = [](const EnergyLight& light) {
    LightSums sum;
    for (const LightBin& bin : light.bins)
      for (const LightBin::Share& share : bin.shares) sum += share.sums;
    return sum;
  };
  for (const LightBin& bin : coarse.bins) EXPECT_NEAR(glm::length(bin.direction), 1.0, 1e-12);
  EXPECT_NEAR(sum_of(coarse).hours, hours_of(steps), 1e-9);
  const glm::dvec3 all = sum_of(exact).beam;
  EXPECT_NEAR(glm::distance(all, sum_of(coarse).beam), 0.0, 1e-6 * glm::length(all));
  EXPECT_NEAR(coarse.open.front().beam.z, all.z, 1e-6 * all.z);
  EXPECT_THROW(beam_light(steps, -1.0), Error);
  EXPECT_THROW(beam_light(steps, NAN), Error);
}

/// A wall from west to east, 0.4 m thick, scanned on both sides and on top.
Points wall() {
  Points points;
  for (const double y : {-0.2, 0.2}) add_rectangle(points, {-15, y, 0}, {30, 0, 0}, {0, 0, 4}, 0.1);
  add_rectangle(points, {-15, -0.2, 4}, {30, 0, 0}, {0, 0.4, 0}, 0.1);
  return points;
}

TEST(SunEnergy, of_a_walls_north_side_are_those_with_the_sun_in_the_north) {
  const Points points = wall();
  const Occluders occluders(octree_of(points), {});
  const SkyTarget north = open_target(occluders, points, {0, 0.2, 2}),
                  south = open_target(occluders, points, {0, -0.2, 2});
  ASSERT_GT(north.normal.y, 0.999);
  ASSERT_LT(south.normal.y, -0.999);
  for (const auto& [from, to] : {std::pair{"2026-06-21T00:00Z", "2026-06-22T00:00Z"},
                                 std::pair{"2026-12-21T00:00Z", "2026-12-22T00:00Z"}}) {
    const std::vector<LitStep> steps = lit(schedule(from, to, 4.0));
    double hours = 0.0, energy = 0.0, south_energy = 0.0;
    for (const LitStep& step : steps) {
      const double cosine = compass_direction(step.azimuth, step.elevation).y;
      hours += cosine > 0.0 ? step.hours : 0.0;
      (cosine > 0.0 ? energy : south_energy) += std::fabs(cosine) * step.hours * step.irradiance / 1000.0;
    }
    const EnergyLight bins = beam_light(steps, 0.0);
    // Points on the wall's edges are spheres, which the sun must pass when it looks along the wall.
    EXPECT_NEAR(at(occluders, north, bins).hours, hours, 0.25) << from;
    EXPECT_NEAR(at(occluders, north, bins).beam / 1000.0, energy, 0.01 + 0.01 * energy) << from;
    EXPECT_NEAR(at(occluders, south, bins).hours, hours_of(steps) - hours, 0.25) << from;
    EXPECT_NEAR(at(occluders, south, bins).beam / 1000.0, south_energy, 0.01 + 0.01 * south_energy) << from;
  }
}

/// The clear sky's beam on a plane, by another way: sums over minutes, with the formulas written again.
double integral(const SunSchedule& range, const glm::dvec3& normal, int days) {
  double watt_minutes = 0.0;
  for (int minute = 0; minute < days * 1440; ++minute) {
    Moment moment = range.from;
    moment.day += std::chrono::days(minute / 1440);
    moment.seconds = 60.0 * (minute % 1440) + 30.0;
    const SunPosition sun = sun_position(moment, {.latitude = range.latitude, .longitude = range.longitude});
    if (sun.elevation <= 0.0) continue;
    const double e = sun.elevation * k_degree, a = sun.azimuth * k_degree;
    const double m = 1.0 / (std::sin(e) + 0.50572 * std::pow(sun.elevation + 6.07995, -1.6364));
    const double d =
        m <= 20
            ? 1 / (6.6296 + 1.7513 * m - 0.1202 * m * m + 0.0065 * std::pow(m, 3) - 0.00013 * std::pow(m, 4))
            : 1 / (10.4 + 0.718 * m);
    const double day = 172.0 + minute / 1440.0;
    const double beam = 1367.0 *
                        (1.0 + 0.03344 * std::cos(2.0 * std::numbers::pi * day / 365.25 - 0.048869)) *
                        std::exp(-0.8662 * 3.0 * m * d);
    const glm::dvec3 way(std::cos(e) * std::sin(a), std::cos(e) * std::cos(a), std::sin(e));
    watt_minutes += beam * std::max(0.0, glm::dot(way, normal));
  }
  return watt_minutes / 60.0 / 1000.0;
}

TEST(SunEnergy, energy_of_an_open_plane_is_the_integral_of_the_model) {
  constexpr int k_days = 5;
  const SunSchedule range = schedule("2026-06-21T00:00Z", "2026-06-26T00:00Z", 5.0);
  for (const double slope : {0.0, 35.0}) {
    const glm::dvec3 up_hill(0.0, std::cos(slope * k_degree), std::sin(slope * k_degree));
    const glm::dvec3 normal(0.0, -std::sin(slope * k_degree), std::cos(slope * k_degree));
    Points points;
    add_rectangle(points, {-3, 0, 0}, {6, 0, 0}, 6.0 * up_hill, 0.1);
    const Occluders occluders(octree_of(points), {});
    const SkyTarget plane = open_target(occluders, points, 3.0 * up_hill);
    const double expected = integral(range, normal, k_days);
    EXPECT_GT(expected, 30.0);
    const std::vector<LitStep> steps = lit(range);
    for (const double bin : {0.0, 3.0}) {
      const Radiation answer = at(occluders, plane, beam_light(steps, bin));
      EXPECT_NEAR(answer.beam / 1000.0, expected, 2e-3 * expected) << slope << " " << bin;
    }
    EXPECT_NEAR(at(occluders, plane, beam_light(steps, 0.0), SkyReceiver::horizontal).beam / 1000.0,
                integral(range, {0, 0, 1}, k_days), slope == 0.0 ? 0.1 : 1.5);
  }
}

TEST(SunEnergy, of_a_years_bins_are_near_those_of_its_steps) {
  const Points points = wall();
  const Occluders occluders(octree_of(points), {});
  const std::vector<LitStep> steps = lit(schedule("2026-01-01T00:00Z", "2027-01-01T00:00Z", 20.0));
  for (const double y : {1.0, 3.0, 6.0}) {
    const SkyTarget ground = target_in_open(end_near_surface(occluders, {0, y, 0}));
    const Radiation exact = at(occluders, ground, beam_light(steps, 0.0)),
                    binned = at(occluders, ground, beam_light(steps, 3.0));
    EXPECT_NEAR(binned.hours, exact.hours, 0.02 * hours_of(steps)) << y;
    EXPECT_NEAR(binned.beam / 1000.0, exact.beam / 1000.0, 0.03 * exact.beam / 1000.0 + 5.0) << y;
  }
}

}  // namespace
}  // namespace alidade::test
