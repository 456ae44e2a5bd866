// SPDX-License-Identifier: MIT
#include "extensions/radiation/irradiance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "extensions/radiation/sky_patches.h"
#include "geo/earth.h"

namespace alidade::test {

using namespace visibility;

namespace {

constexpr double k_degree = std::numbers::pi / 180.0;

TEST(BeamIrradiance, is_that_of_the_solar_radiation_atlas) {
  // By hand: mass 1 (0.99971 by its formula), 1 / 8.26717 thick, turbidity 3, at the mean distance.
  EXPECT_NEAR(beam_irradiance(90.0, 93.99, {}), 1367.0 * std::exp(-0.8662 * 3.0 / 8.26717), 0.5);
  EXPECT_NEAR(beam_irradiance(90.0, 2.84, {}) / beam_irradiance(90.0, 185.46, {}), 1.03344 / 0.96656, 1e-5);
  EXPECT_EQ(beam_irradiance(0.0, 1.0, {}), 0.0);
  EXPECT_EQ(beam_irradiance(-5.0, 1.0, {}), 0.0);
  EXPECT_GT(beam_irradiance(30.0, 1.0, {.height = 3000.0}), 1.1 * beam_irradiance(30.0, 1.0, {}));
  EXPECT_LT(beam_irradiance(30.0, 1.0, {.linke_turbidity = 6.0}), 0.8 * beam_irradiance(30.0, 1.0, {}));
  // Both formulas for the thickness meet near mass 20, which is an elevation of 2.0 degrees.
  EXPECT_NEAR(beam_irradiance(1.98, 1.0, {}), beam_irradiance(2.02, 1.0, {}), 3.0);
}

TEST(DiffuseIrradiance, is_that_of_the_solar_radiation_atlas) {
  // By hand, turbidity 3, zenith: Tn = 0.0792033, A1 = 0.1081542, A2 = 1.996586, A3 = -1.1082359.
  EXPECT_NEAR(diffuse_irradiance(90.0, 93.99, {}), 1367.0 * 0.0792033 * (0.1081542 + 1.996586 - 1.1082359),
              0.2);
  EXPECT_NEAR(diffuse_irradiance(30.0, 93.99, {}), 1367.0 * 0.0792033 * (0.1081542 + 0.998293 - 0.277059),
              0.2);
  // Turbidity 8: A1 is 0.0022 / Tn.
  const double tn = -0.015843 + 8.0 * (0.030543 + 8.0 * 0.0003797);
  EXPECT_NEAR(diffuse_irradiance(0.001, 93.99, {.linke_turbidity = 8.0}), 1367.0 * 0.0022, 0.03);
  EXPECT_GT(0.0022, tn * (0.26463 + 8.0 * (-0.061581 + 8.0 * 0.0031408)));
  EXPECT_EQ(diffuse_irradiance(0.0, 1.0, {}), 0.0);
}

TEST(SkyPatches, cover_the_sky_once) {
  glm::dvec3 sum(0.0);
  for (int patch = 0; patch < k_sky_patches; ++patch) {
    const SkyCell cell = sky_patch(patch);
    sum += direction_integral(cell);
    const double middle = 0.5 * (cell.azimuth_min + cell.azimuth_max),
                 height = 0.5 * (cell.elevation_min + cell.elevation_max);
    EXPECT_EQ(sky_patch_at(middle, height), patch);
    EXPECT_EQ(sky_patch_at(middle + 360.0, height), patch);
  }
  EXPECT_NEAR(sum.x, 0.0, 1e-12);
  EXPECT_NEAR(sum.y, 0.0, 1e-12);
  EXPECT_NEAR(sum.z, std::numbers::pi, 1e-12);
  EXPECT_EQ(sky_patch_at(77.0, 90.0), k_sky_patches - 1);
  EXPECT_EQ(sky_patch_at(354.1, 0.0), 0) << "the first patch has its middle in the north";
}

TEST(SkyPatches, integral_of_a_small_cell_is_its_direction_times_its_solid_angle) {
  const double size = 0.01 * k_degree;
  const glm::dvec3 integral = direction_integral({100.0, 100.01, 40.0, 40.01}),
                   expected =
                       size * size * std::cos(40.005 * k_degree) * geo::compass_direction(100.005, 40.005);
  EXPECT_NEAR(glm::distance(integral, expected), 0.0, 1e-6 * glm::length(expected));
}

double horizontal_of(const std::array<double, k_sky_patches>& radiances) {
  double sum = 0.0;
  for (int patch = 0; patch < k_sky_patches; ++patch)
    sum += radiances[static_cast<std::size_t>(patch)] * direction_integral(sky_patch(patch)).z;
  return sum;
}

TEST(SkyRadiances, give_the_horizontal_its_diffuse_irradiance_in_all_weathers) {
  for (const double elevation : {0.5, 10.0, 45.0, 89.9})
    for (const double direct : {0.0, 20.0, 60.0, 150.0, 300.0, 500.0, 700.0, 950.0})
      for (const double diffuse : {1.0, 40.0, 120.0, 400.0}) {
        const SkyState state{130.0, elevation, direct, diffuse};
        EXPECT_NEAR(horizontal_of(sky_radiances(state)), diffuse, 1e-4) << elevation << " " << direct;
      }
  EXPECT_EQ(horizontal_of(sky_radiances({130.0, 30.0, 500.0, 0.0})), 0.0);
}

TEST(SkyRadiances, of_a_clear_sky_are_highest_around_the_sun_and_of_an_overcast_one_at_the_zenith) {
  const auto brightest = [](const SkyState& state) {
    const auto radiances = sky_radiances(state);
    return static_cast<int>(std::ranges::max_element(radiances) - radiances.begin());
  };
  EXPECT_EQ(brightest({180.0, 30.0, 850.0, 80.0}), sky_patch_at(180.0, 30.0));
  EXPECT_EQ(brightest({240.0, 17.0, 700.0, 70.0}), sky_patch_at(240.0, 17.0));
  const auto overcast = sky_radiances({180.0, 30.0, 0.0, 100.0});
  const auto at = [&](double azimuth, double elevation) {
    return overcast[static_cast<std::size_t>(sky_patch_at(azimuth, elevation))];
  };
  EXPECT_GT(at(0.0, 90.0), 1.3 * at(0.0, 6.0));
  EXPECT_LT(at(180.0, 30.0), 1.5 * at(0.0, 30.0)) << "the sun hardly shows";
}

TEST(SkyRadiances, follow_the_equations_of_the_all_weather_model) {
  // Clearness of the last row: written again for one patch against another.
  const double zenith = 60.0 * k_degree, direct = 850.0, diffuse = 70.0;
  const double brightness =
      diffuse * (1.0 / (std::sin(30.0 * k_degree) + 0.50572 * std::pow(36.07995, -1.6364))) / 1367.0;
  const auto parameter = [&](double x1, double x2, double x3, double x4) {
    return x1 + x2 * zenith + brightness * (x3 + x4 * zenith);
  };
  const double a = parameter(-1.05, 0.0289, 0.4260, 0.3590), b = parameter(-0.3250, 0.1156, 0.7781, 0.0025),
               c = parameter(31.0625, -14.5, -46.1148, 55.375), d = parameter(-7.2312, 0.4050, 13.35, 0.6234),
               e = parameter(1.5, -0.6426, 1.8564, 0.5636);
  const auto relative = [&](double azimuth, double elevation) {
    const double gamma =
        std::acos(glm::dot(geo::compass_direction(180.0, 30.0), geo::compass_direction(azimuth, elevation)));
    return (1.0 + a * std::exp(b / std::sin(elevation * k_degree))) *
           (1.0 + c * std::exp(d * gamma) + e * std::cos(gamma) * std::cos(gamma));
  };
  const auto radiances = sky_radiances({180.0, 30.0, direct, diffuse});
  const auto at = [&](double azimuth, double elevation) {
    return radiances[static_cast<std::size_t>(sky_patch_at(azimuth, elevation))];
  };
  EXPECT_NEAR(at(180.0, 30.0) / at(0.0, 18.0), relative(180.0, 30.0) / relative(0.0, 18.0), 1e-4);
  EXPECT_NEAR(at(90.0, 42.0) / at(0.0, 18.0), relative(90.0, 42.0) / relative(0.0, 18.0), 1e-4);
}

}  // namespace
}  // namespace alidade::test
