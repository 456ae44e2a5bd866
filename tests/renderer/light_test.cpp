// SPDX-License-Identifier: MIT
#include "renderer/light.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/renderer/tracer_scenes.h"

namespace alidade {

using namespace geo;
using namespace renderer;

namespace {

TEST(Sun, azimuth_is_clockwise_from_north_and_elevation_above_the_horizon) {
  const auto towards = [](double azimuth, double elevation) {
    return SunDisc({azimuth, elevation}).center();
  };
  EXPECT_NEAR(glm::length(towards(0.0, 0.0) - glm::dvec3(0, 1, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(towards(90.0, 0.0) - glm::dvec3(1, 0, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(towards(123.0, 90.0) - glm::dvec3(0, 0, 1)), 0.0, 1e-15);
  EXPECT_NEAR(towards(225.0, 30.0).x, -std::sqrt(3.0 / 8.0), 1e-15);
  EXPECT_NEAR(towards(225.0, 30.0).z, 0.5, 1e-15);
}

TEST(Sun, radiance_of_the_disc_is_irradiance_over_solid_angle) {
  const Sun sun{
      .azimuth = 200, .elevation = 35, .irradiance = Rgb(3.0f, 2.0f, 1.0f), .angular_diameter = 0.53};
  const SunDisc disc(sun);
  const double half = 0.265 * k_pi / 180.0;
  const double solid_angle = 2.0 * k_pi * (1.0 - std::cos(half));
  EXPECT_NEAR(disc.radiance(disc.center()).g * solid_angle, 2.0, 2e-5);
  const Basis basis = basis_around(disc.center());
  const auto at = [&](double angle) {
    return disc.radiance(basis.to_world({std::sin(angle), 0.0, std::cos(angle)}));
  };
  EXPECT_GT(at(0.999 * half).r, 0.0f);
  EXPECT_EQ(at(1.001 * half).r, 0.0f);
}

TEST(Sun, sampled_directions_lie_in_the_disc_and_carry_the_irradiance) {
  for (const double diameter : {0.0, 0.53, 60.0, 170.0}) {
    const SunDisc disc(
        {.azimuth = 77, .elevation = 21, .irradiance = Rgb(2.0f), .angular_diameter = diameter});
    double irradiance = 0.0;
    constexpr int k_side = 100;
    for (int i = 0; i < k_side * k_side; ++i) {
      const glm::dvec3 direction = disc.sample({(i % k_side + 0.5) / k_side, (i / k_side + 0.5) / k_side});
      ASSERT_GE(glm::dot(direction, disc.center()), std::cos(0.5 * diameter * k_pi / 180.0) - 1e-12);
      irradiance += disc.sample_weight().r * glm::dot(direction, disc.center()) / (k_side * k_side);
    }
    EXPECT_NEAR(irradiance, 2.0, 1e-4) << diameter;
  }
}

TEST(Sun, too_small_for_its_edge_is_parallel_light) {
  for (const double diameter : {1e-300, 1e-18, 1e-6, 1e-5, 2e-5, 1e-3}) {
    const SunDisc disc({.irradiance = Rgb(1e9f), .angular_diameter = diameter});
    EXPECT_EQ(disc.is_parallel(), diameter < 1.7e-5) << diameter;
    const Rgb radiance = disc.radiance(disc.center());
    EXPECT_TRUE(std::isfinite(radiance.r)) << diameter;
    EXPECT_EQ(radiance.r > 0.0f, !disc.is_parallel()) << diameter;
    EXPECT_NEAR(glm::dot(disc.sample({0.5, 0.5}), disc.center()), 1.0, 1e-9);
    EXPECT_NEAR(disc.sample_weight().r, 1e9f, 1e3f);
  }
}

Scene lamps() {
  Scene scene;
  scene.objects = {Sphere{{0, 0, 5}, 1.0, Emissive{Rgb(2.0f)}}, GroundPlane{0.0, Emissive{}},
                   Sphere{{4, 0, 3}, 0.5, Emissive{Rgb(1.0f, 8.0f, 3.0f)}},
                   Sphere{{0, 4, 3}, 0.5, Lambertian{}}, Sphere{{0, 0, 9}, 0.5, Emissive{Rgb(0.0f)}}};
  return scene;
}

TEST(Light, every_sampled_direction_meets_its_sphere_with_the_density_that_pdf_tells) {
  const Scene scene = lamps();
  const Lights lights(scene);
  ASSERT_TRUE(lights.has_spheres());
  test::Random random;
  int counts[5] = {};
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 position = random.in_cube() * 2.0;
    const LightSample chosen = lights.sample(position, random.unit(), {random.unit(), random.unit()});
    ++counts[chosen.object];
    const Sphere& sphere = std::get<Sphere>(scene.objects[chosen.object]);
    const glm::dvec3 offset = sphere.center - position;
    const double ahead = glm::dot(offset, chosen.direction);
    ASSERT_GT(ahead, 0.0);
    ASSERT_LE(glm::length(offset - ahead * chosen.direction), sphere.radius * (1.0 + 1e-9));
    ASSERT_DOUBLE_EQ(lights.pdf(chosen.object, position), chosen.pdf);
  }
  // Power goes with radius squared times radiance: 1 * 6 against 0.25 * 12.
  EXPECT_NEAR(counts[0] / 20000.0, 2.0 / 3.0, 0.02);
  EXPECT_NEAR(counts[2] / 20000.0, 1.0 / 3.0, 0.02);
  EXPECT_EQ(lights.pdf(1, {0, 0, 1}), 0.0);
  EXPECT_EQ(lights.pdf(3, {0, 0, 1}), 0.0);
}

TEST(Light, density_over_the_visible_cap_sums_to_one) {
  Scene scene;
  scene.objects = {Sphere{{0, 0, 5}, 1.0, Emissive{}}};
  const Lights lights(scene);
  for (const double distance : {1.0001, 2.0, 100.0, 1e6}) {
    const double sine = 1.0 / distance;
    const double solid_angle = 2.0 * k_pi * sine * sine / (1.0 + std::sqrt(1.0 - sine * sine));
    EXPECT_NEAR(lights.pdf(0, {0.0, 0.0, 5.0 - distance}) * solid_angle, 1.0, 1e-9);
  }
  EXPECT_NEAR(lights.pdf(0, {0.0, 0.0, 5.0}) * 4.0 * k_pi, 1.0, 1e-12);  // inside: all directions
}

TEST(Light, visible_share_is_the_filled_part_of_a_hemisphere) {
  const Scene scene = lamps();
  const Lights lights(scene);
  EXPECT_NEAR(lights.visible_share(0, {0, 0, 3}), 1.0 - std::sqrt(0.75), 1e-12);
  EXPECT_NEAR(lights.visible_share(0, {0, 0, -995}), 0.5e-6, 1e-11);
  EXPECT_EQ(lights.visible_share(0, {0, 0, 5.5}), 1.0);
  EXPECT_EQ(lights.visible_share(1, {0, 0, 3}), 1.0);
}

TEST(Sky, gradient_goes_with_the_sine_of_the_elevation) {
  const Sky sky = GradientSky{Rgb(1.0f), Rgb(0.0f)};
  EXPECT_EQ(sky_radiance(sky, {0, 0, 1}), Rgb(0.0f));
  EXPECT_EQ(sky_radiance(sky, {0.8, 0, 0.6}).r, 1.0f - 0.6f);
  EXPECT_EQ(sky_radiance(sky, {0, 1, 0}), Rgb(1.0f));
  EXPECT_EQ(sky_radiance(sky, {0, 0.6, -0.8}), Rgb(1.0f));
  EXPECT_EQ(sky_radiance(ConstantSky{Rgb(0.3f)}, {0, 0.6, -0.8}), Rgb(0.3f));
}

}  // namespace
}  // namespace alidade
