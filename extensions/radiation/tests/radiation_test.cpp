// SPDX-License-Identifier: MIT
// Radiation of places whose answer is known on paper.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/error.h"
#include "extensions/radiation/sky_patches.h"
#include "extensions/radiation/tests/radiation_of_cloud.h"
#include "geo/earth.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

constexpr double k_degree = std::numbers::pi / 180.0;

template <class Height>
Occluders terrain_of(int columns, int rows, const Height& height) {
  Raster<float> heights({{-0.5 * columns, 0.5 * rows}, 1.0, columns, rows}, 0.0f);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      heights.at(column, row) = static_cast<float>(height(heights.grid.center(column, row)));
  OccluderOptions options;
  options.terrain = std::make_shared<const TerrainSurface>(std::move(heights));
  return Occluders(build(PointCloud()), options);
}

Occluders flat() {
  return terrain_of(40, 40, [](const glm::dvec2&) { return 0.0; });
}

/// Morning, noon and evening under a clear, a hazy and an overcast sky; the last in another period.
const std::vector<LitStep>& steps() {
  static const std::vector<LitStep> three{{105.0, 20.0, 1.5, 700.0, 60.0, 1367.0, 0},
                                          {180.0, 62.0, 2.0, 500.0, 230.0, 1367.0, 0},
                                          {251.0, 33.0, 1.0, 0.0, 120.0, 1367.0, 1}};
  return three;
}

std::vector<Radiation> at(const Occluders& occluders, const glm::dvec3& position, const EnergyLight& light,
                          const RadiationOptions& options = {}) {
  const SkyTarget target = target_in_open({position});
  std::vector<Radiation> answers(static_cast<std::size_t>(light.periods));
  radiation(occluders, std::span(&target, 1), light, options, answers);
  return answers;
}

/// The sky's light on a receiver, patch by patch in cells of half a degree, where `sees` a direction.
template <class Sees>
double diffuse_by_integral(const LitStep& step, const glm::dvec3& normal, const Sees& sees) {
  const auto radiances =
      sky_radiances({step.azimuth, step.elevation, step.irradiance, step.diffuse, step.extraterrestrial});
  double sum = 0.0;
  for (double azimuth = 0.0; azimuth < 360.0; azimuth += 0.5) {
    for (double elevation = 0.0; elevation < 90.0; elevation += 0.5) {
      const glm::dvec3 direction = compass_direction(azimuth + 0.25, elevation + 0.25);
      if (!sees(direction) || glm::dot(direction, normal) <= 0.0) continue;
      sum += radiances[static_cast<std::size_t>(sky_patch_at(azimuth + 0.25, elevation + 0.25))] *
             glm::dot(direction_integral({azimuth, azimuth + 0.5, elevation, elevation + 0.5}), normal);
    }
  }
  return step.hours * sum;
}

TEST(Radiation, of_an_open_plane_is_its_closed_formula_by_bins_and_by_fans) {
  const Occluders occluders = flat();
  for (const bool by_horizons : {false, true}) {
    const EnergyLight light = energy_light(steps(), 2, {.by_horizons = by_horizons});
    EXPECT_EQ(light.bins.empty(), by_horizons);
    const std::vector<Radiation> answers = at(occluders, {0.5, 0.5, 0.0}, light);
    EXPECT_NEAR(answers[0].hours, 3.5, 1e-6);
    EXPECT_NEAR(answers[0].beam,
                1.5 * 700.0 * std::sin(20.0 * k_degree) + 2.0 * 500.0 * std::sin(62.0 * k_degree), 1e-3);
    EXPECT_NEAR(answers[0].diffuse, 1.5 * 60.0 + 2.0 * 230.0, 1e-2);
    EXPECT_EQ(answers[0].reflected, 0.0f);
    EXPECT_NEAR(answers[1].hours, 1.0, 1e-6);
    EXPECT_EQ(answers[1].beam, 0.0f);
    EXPECT_NEAR(answers[1].diffuse, 120.0, 1e-2);
    EXPECT_NEAR(answers[1].global(), 120.0, 1e-2);
  }
}

TEST(Radiation, of_a_tilted_receiver_has_incidence_the_sky_before_it_and_the_light_of_the_ground) {
  const Occluders occluders = flat();
  const auto all = [](const glm::dvec3&) { return true; };
  for (const double tilt : {30.0, 60.0, 90.0}) {
    for (const double aspect : {180.0, 300.0}) {
      const glm::dvec3 normal = tilted_normal(tilt, aspect);
      double beam = 0.0, diffuse = 0.0, global = 0.0, hours = 0.0;
      for (const LitStep& step : std::span<const LitStep>(steps()).first(2)) {
        const glm::dvec3 sun = compass_direction(step.azimuth, step.elevation);
        const double cosine = glm::dot(sun, normal);
        hours += cosine > 0.0 ? step.hours : 0.0;
        beam += step.hours * step.irradiance * std::max(cosine, 0.0);
        diffuse += diffuse_by_integral(step, normal, all);
        global += step.hours * (step.irradiance * sun.z + step.diffuse);
      }
      for (const bool by_horizons : {false, true}) {
        const EnergyLight light = energy_light(steps(), 2, {.by_horizons = by_horizons});
        const Radiation answer =
            at(occluders, {0.5, 0.5, 0.0}, light, {.normal = normal, .albedo = 0.3}).front();
        EXPECT_NEAR(answer.hours, hours, 1e-6) << tilt << " " << aspect;
        EXPECT_NEAR(answer.beam, beam, 1e-3) << tilt << " " << aspect;
        EXPECT_NEAR(answer.diffuse, diffuse, (by_horizons ? 0.005 : 0.02) * diffuse) << tilt << " " << aspect;
        EXPECT_NEAR(answer.reflected, 0.3 * global * (1.0 - std::cos(tilt * k_degree)) / 2.0, 1e-2);
      }
    }
  }
}

TEST(Radiation, in_a_crater_is_that_of_the_sky_above_its_rim) {
  // Seen from the middle, the rim is 35 degrees high all round.
  constexpr double k_radius = 30.0, k_rim = 35.0;
  const double height = k_radius * std::tan(k_rim * k_degree);
  const Occluders occluders = terrain_of(
      80, 80, [&](const glm::dvec2& position) { return glm::length(position) >= k_radius ? height : 0.0; });
  const double sine = std::sin((k_rim - 0.4) * k_degree);  // the rim's first cells are up to one farther away
  for (const bool by_horizons : {false, true}) {
    const EnergyLight light = energy_light(steps(), 2, {.by_horizons = by_horizons});
    const std::vector<Radiation> answers = at(occluders, {0.0, 0.0, 0.0}, light);
    EXPECT_NEAR(answers[0].hours, 2.0, 1e-6) << "the noon alone";
    EXPECT_NEAR(answers[0].beam, 1000.0 * std::sin(62.0 * k_degree), 1e-3);
    EXPECT_EQ(answers[1].hours, 0.0f);
    double expected = 0.0;
    for (const LitStep& step : std::span<const LitStep>(steps()).first(2))
      expected += diffuse_by_integral(step, {0, 0, 1}, [&](const glm::dvec3& way) { return way.z > sine; });
    EXPECT_NEAR(answers[0].diffuse, expected, 0.02 * expected) << by_horizons;
  }
}

TEST(SkyView, above_horizons_is_the_mean_of_the_squared_cosines_of_their_elevations) {
  // Steyn 1980; one wall in the north seen under the angle b: (1 + cos b) / 2 where it is endless.
  const auto view = [](const Occluders& occluders, const glm::dvec3& position) {
    const SkyTarget target = target_in_open({position});
    float of_target = 0.0f;
    sky_views(occluders, std::span(&target, 1), {.directions = 256}, std::span(&of_target, 1));
    return of_target;
  };
  EXPECT_NEAR(view(flat(), {0.5, 0.5, 0.0}), 1.0, 1e-6);
  const Occluders plateau =
      terrain_of(2000, 20, [](const glm::dvec2& position) { return position.y > 4.0 ? 5.0 : 0.0; });
  // Its edge is at y = 4.5.
  EXPECT_NEAR(view(plateau, {0.5, -0.5, 0.0}), 0.5 * (1.0 + std::cos(std::atan2(5.0, 5.0))), 0.002);
  EXPECT_NEAR(view(plateau, {0.5, -0.5, 5.0}), 1.0, 1e-6);
}

/// The share of an even sky on the horizontal: every patch has the radiance 1/pi.
double view_by_patches(const Occluders& occluders, const SkyTarget& target) {
  EnergyLight light = energy_light(std::vector<LitStep>{{180.0, 40.0, 1.0, 500.0, 100.0, 1367.0, 0}}, 1, {});
  EXPECT_EQ(light.bins.size(), 1u + k_sky_patches);
  for (int patch = 0; patch < k_sky_patches; ++patch) {
    auto& shares = light.bins[static_cast<std::size_t>(patch) + 1].shares;
    shares.front().sums.diffuse = direction_integral(sky_patch(patch)) / std::numbers::pi;
  }
  Radiation answer;
  radiation(occluders, std::span(&target, 1), light, {}, std::span(&answer, 1));
  return answer.diffuse;
}

TEST(Radiation, of_an_even_sky_is_the_sky_view_factor) {
  // In the middle between infinite walls seen under the angle b: cos b (Johnson and Watson 1984).
  for (const auto& [half_width, height] : {std::pair{4.0, 2.0}, std::pair{4.0, 6.0}, std::pair{3.0, 9.0}}) {
    Points points;
    add_rectangle(points, {-half_width, -80, 0}, {2.0 * half_width, 0, 0}, {0, 160, 0}, 0.15);
    for (const double side : {-half_width, half_width})
      add_rectangle(points, {side, -80, 0}, {0, 160, 0}, {0, 0, height}, 0.15);
    const Occluders occluders(octree_of(points), {.radius = 0.11});
    const SkyTarget target = target_in_open(end_near_surface(occluders, {0.03, 0.02, 0.05}));
    EXPECT_NEAR(view_by_patches(occluders, target), std::cos(std::atan2(height, half_width)), 0.02) << height;
  }
  EXPECT_NEAR(view_by_patches(flat(), target_in_open({{0.5, 0.5, 0.0}})), 1.0, 1e-6);
}

TEST(Radiation, by_horizons_is_that_of_lines_of_sight_at_every_step) {
  const Occluders occluders = terrain_of(60, 50, [](const glm::dvec2& position) {
    const bool is_house =
        std::fmod(position.x + 100.0, 15.0) < 7.0 && std::fmod(position.y + 100.0, 12.0) < 6.0;
    return 3.0 * std::sin(0.2 * position.x) * std::cos(0.15 * position.y) + (is_house ? 8.0 : 0.0);
  });
  std::vector<LitStep> many;
  for (double azimuth = 60.0; azimuth < 300.0; azimuth += 3.7)
    for (double elevation = 3.0; elevation < 60.0; elevation += 4.1)
      many.push_back({azimuth, elevation, 1.0, 500.0, 100.0, 1367.0, 0});
  const EnergyLight lines = energy_light(many, 1, {.has_sky = false}),
                    horizons = energy_light(many, 1, {.has_sky = false, .by_horizons = true}),
                    sectors = energy_light(many, 1, {.bin = 1.0, .has_sky = false, .by_horizons = true});
  EXPECT_LE(sectors.fans.size(), 240u);
  double difference = 0.0, of_sectors = 0.0;
  int count = 0;
  const Ground ground(*occluders.options().terrain);
  for (double x = -19.5; x < 20.0; x += 3.0) {
    for (double y = -14.5; y < 15.0; y += 3.0) {
      const glm::dvec3 position(x, y, *ground.at({x, y}) + 0.01);
      const Radiation truth = at(occluders, position, lines).front();
      // Lines may differ that graze the surface within a millimetre.
      EXPECT_NEAR(at(occluders, position, horizons).front().hours, truth.hours, 1.0) << x << " " << y;
      difference += at(occluders, position, horizons).front().hours - truth.hours;
      of_sectors += std::fabs(at(occluders, position, sectors).front().hours - truth.hours);
      ++count;
    }
  }
  EXPECT_LT(std::fabs(difference) / count, 0.1);
  EXPECT_LT(of_sectors / count, 0.01 * static_cast<double>(many.size()));
}

TEST(Radiation, by_horizons_requires_a_terrain_alone) {
  const EnergyLight light = energy_light(steps(), 2, {.by_horizons = true});
  const Occluders points(octree_of({{1, 0, 0}}), {.radius = 0.1});
  EXPECT_FALSE(has_horizons(points, INFINITY));
  EXPECT_TRUE(has_horizons(flat(), INFINITY));
  EXPECT_FALSE(has_horizons(flat(), 1000.0));
  EXPECT_THROW(at(points, {0, 0, 0}, light), Error);
  EXPECT_THROW(at(flat(), {0, 0, 0}, light, {.max_distance = 10.0}), Error);
  EXPECT_THROW(at(flat(), {0, 0, 0}, light, {.albedo = 1.1}), Error);
}

TEST(GroundRadiation, of_slopes_is_that_of_their_normals) {
  // A plane that falls to the south by 20 degrees.
  const double fall = std::tan(20.0 * k_degree);
  const Occluders occluders =
      terrain_of(40, 40, [&](const glm::dvec2& position) { return fall * position.y; });
  const Ground ground(*occluders.options().terrain);
  const EnergyLight light = energy_light(steps(), 2, {.by_horizons = true});
  const RasterGrid grid = grid_over({{-2, -2, 0}, {2, 2, 0}}, 1.0);
  const std::size_t cell = 2 * (static_cast<std::size_t>(grid.columns) + 1);  // of two periods
  const Radiation level =
      ground_radiation(occluders, ground, grid, 0.0, light, {.receiver = SkyReceiver::horizontal})[cell];
  const Radiation slope = ground_radiation(occluders, ground, grid, 0.0, light, {})[cell];
  const glm::dvec3 normal = tilted_normal(20.0, 180.0);
  double beam = 0.0;
  for (const LitStep& step : std::span<const LitStep>(steps()).first(2))
    beam += step.hours * step.irradiance * glm::dot(compass_direction(step.azimuth, step.elevation), normal);
  EXPECT_NEAR(slope.beam, beam, 1e-3 * beam);
  EXPECT_NEAR(level.beam, 1.5 * 700.0 * std::sin(20.0 * k_degree) + 1000.0 * std::sin(62.0 * k_degree), 1e-2);
  EXPECT_LT(level.diffuse, 550.0) << "the slope hides a part of the sky";
  EXPECT_GT(level.diffuse, 500.0);
  const auto views = [&](SkyReceiver receiver) {
    return ground_sky_views(occluders, ground, grid, 0.0, {.directions = 512, .receiver = receiver}).at(1, 1);
  };
  EXPECT_NEAR(views(SkyReceiver::surface), 0.5 * (1.0 + std::cos(20.0 * k_degree)), 0.005);
}

TEST(LitSteps, of_a_weather_file_have_all_energy_of_their_hours) {
  // Every hour of the year has 120 W/m2 of the sky, hours without sun nothing of it.
  std::string text =
      "LOCATION,a,b,c,d,1,48.0,0.0,0.0,500\nDESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\n"
      "GROUND TEMPERATURES,0\nHOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,a\nCOMMENTS 2,b\n"
      "DATA PERIODS,1,1,Data,Sunday,1/1,12/31\n";
  constexpr std::array k_days = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  for (int month = 1; month <= 12; ++month)
    for (int day = 1; day <= k_days[static_cast<std::size_t>(month - 1)]; ++day)
      for (int hour = 1; hour <= 24; ++hour)
        text += fmt::format("1999,{},{},{},0,C,1,1,9,9,0,0,3,0,240,120,0,0\n", month, day, hour);
  InputFile file(std::as_bytes(std::span(text)), "even.epw");
  const Weather weather(file);
  const LightSource source{.weather = &weather};
  SunSchedule schedule;
  schedule.from = parse_date_time("2026-06-21T00:00Z");
  schedule.to = parse_date_time("2026-06-22T00:00Z");
  schedule.step_minutes = 10.0;
  schedule.latitude = 48.0;
  double energy = 0.0, beam = 0.0, hours = 0.0;
  for (const LitStep& step : lit_steps(schedule, sun_steps(schedule), source)) {
    energy += step.hours * step.diffuse;
    beam += step.hours * step.irradiance;
    hours += step.hours;
  }
  // The sun is up for 16 hours, in parts of 17 or 18.
  EXPECT_NEAR(hours, 16.0, 0.3);
  const double touched = energy / 120.0;
  EXPECT_NEAR(touched, std::round(touched), 1e-9);
  EXPECT_GE(touched, hours);
  EXPECT_LE(touched, 18.0);
  EXPECT_NEAR(beam, 2.0 * energy, 1e-6);
  schedule.to = parse_date_time("2026-06-21T12:05Z");
  EXPECT_EQ(lit_steps(schedule, sun_steps(schedule), source).back().diffuse, 120.0)
      << "a step cut short has no more than its time";
}

TEST(LitSteps, have_the_turbidity_of_their_month) {
  SunSchedule schedule;
  schedule.from = parse_date_time("2026-01-31T12:00Z");
  schedule.to = parse_date_time("2026-02-01T13:00Z");
  schedule.step_minutes = 60.0;
  schedule.latitude = 48.0;
  LightSource source;
  source.monthly_turbidity.emplace();
  source.monthly_turbidity->fill(2.0);
  (*source.monthly_turbidity)[1] = 6.0;
  const std::vector<LitStep> two = lit_steps(schedule, sun_steps(schedule), source);
  EXPECT_GT(two.front().irradiance, 1.3 * two.back().irradiance);
  EXPECT_LT(two.front().diffuse, two.back().diffuse);
  (*source.monthly_turbidity)[11] = 0.5;
  EXPECT_THROW(lit_steps(schedule, sun_steps(schedule), source), Error);
  source = {.air = {.linke_turbidity = 0.0}};
  EXPECT_THROW(lit_steps(schedule, sun_steps(schedule), source), Error);
}

}  // namespace
}  // namespace alidade::test
