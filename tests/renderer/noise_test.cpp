// SPDX-License-Identifier: MIT
#include "renderer/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

#include "tests/renderer/tracer_scenes.h"
#include "tests/support/random.h"

namespace alidade {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

/// Sums over an image and many seeds.
struct Spread {
  double mean = 0.0;      ///< of all colours
  double reported = 0.0;  ///< mean variance that the films report
  double measured = 0.0;  ///< variance of a pixel's colour between seeds

  double ratio() const { return reported / measured; }
};

constexpr int k_seeds = 200;

Spread spread_of(Scene scene, const LoadedCloud* cloud, int samples, std::optional<double> target = {}) {
  scene.render.samples = samples;
  RenderOptions options;
  options.layers = {{Layer::color, Layer::variance}};
  options.target_noise = target;
  std::vector<glm::dvec3> mean, squares;
  Spread spread;
  for (int seed = 1; seed <= k_seeds; ++seed) {
    scene.render.seed = static_cast<std::uint64_t>(seed);
    const Film film = render(scene, cloud, options);
    mean.resize(film.count(), glm::dvec3(0.0));
    squares.resize(film.count(), glm::dvec3(0.0));
    for (std::size_t pixel = 0; pixel < film.count(); ++pixel) {
      const glm::dvec3 difference = glm::dvec3(film.color[pixel]) - mean[pixel];
      mean[pixel] += difference / static_cast<double>(seed);
      squares[pixel] += difference * (glm::dvec3(film.color[pixel]) - mean[pixel]);
      for (int channel = 0; channel < 3; ++channel)
        spread.reported += film.variance[pixel][channel] / k_seeds;
    }
  }
  for (const glm::dvec3& square : squares)
    spread.measured += (square.x + square.y + square.z) / (k_seeds - 1);
  return spread;
}

/// The limits of renderer/noise.h: never too low but for the noise of the test, and at most so much too high.
constexpr double k_most_below = 1.0 / 1.3, k_most_above = 4.0;

void expect_right(const Scene& scene, const LoadedCloud* cloud, std::initializer_list<int> samples) {
  for (const int n : samples) {
    const Spread spread = spread_of(scene, cloud, n);
    EXPECT_GT(spread.ratio(), k_most_below) << n << " samples";
    EXPECT_LT(spread.ratio(), k_most_above) << n << " samples";
  }
}

/// Sums as those of a tile whose V(j) are these, for so many samples of one pixel.
LevelSums levels_of(const std::function<double(int)>& variance) {
  LevelSums levels{};
  for (int j = 0; j < static_cast<int>(levels.size()); ++j)
    levels[static_cast<std::size_t>(j)] = variance(j) - variance(j + 1);
  return levels;
}

/// What the rule makes of the sum of squares that samples with these V(j) have on average.
double variance_told(const std::function<double(int)>& variance, int level) {
  const auto n = std::uint32_t{1} << level;
  const double squares = n * (variance(0) - variance(level));
  return squares * mean_variance_scale(levels_of(variance), n);
}

TEST(Noise, is_exact_for_independent_and_for_smooth_parts_in_any_mixture) {
  for (const double smooth : {0.0, 0.01, 1.0, 100.0, 1e6}) {
    const auto variance = [&](int j) { return std::ldexp(1.0, -j) + smooth * std::ldexp(1.0, -3 * j); };
    for (int level = 2; level <= 20; ++level) {
      EXPECT_NEAR(variance_told(variance, level), variance(level), 1e-6 * variance(level))
          << smooth << " " << level;
    }
  }
}

TEST(Noise, is_never_too_low_for_rates_between) {
  for (const double rate : {1.2, 1.5, 2.0, 2.5, 3.0}) {
    const auto variance = [&](int j) { return std::pow(2.0, -rate * j); };
    for (int level = 2; level <= 12; ++level) {
      EXPECT_GE(variance_told(variance, level), 0.999 * variance(level)) << rate;
      EXPECT_LE(variance_told(variance, level), 2.3 * variance(level)) << rate;
    }
  }
}

TEST(Noise, of_independent_samples_is_sample_variance_over_their_number) {
  const LevelSums levels = levels_of([](int j) { return std::ldexp(1.0, -j); });
  for (const std::uint32_t n : {2u, 3u, 5u, 6u, 7u, 12u, 50u, 100u, 1023u, 1u << 24})
    EXPECT_NEAR(mean_variance_scale(levels, n) * n * (n - 1.0), 1.0, 1e-9) << n;
}

TEST(Noise, of_one_sample_is_not_known) {
  ImageState state(3, 2, true);
  EXPECT_EQ(tile_noise(state, 0).error(0.01), INFINITY);
  const std::vector<PathResult> results(6, {Rgb(0.5f), true, 1});
  add_samples(state, 0, results);
  EXPECT_EQ(tile_noise(state, 0).error(0.01), INFINITY);
  add_samples(state, 0, results);
  EXPECT_EQ(tile_noise(state, 0).error(0.01), 0.0);
}

TEST(Noise, error_is_relative_to_the_mean_luminance_and_the_floor) {
  Noise noise{.variance = 4 * 0.09, .luminance = 4 * 0.5, .pixels = 4};
  EXPECT_DOUBLE_EQ(noise.error(0.0), 0.3 / 0.5);
  EXPECT_DOUBLE_EQ(noise.error(0.1), 0.3 / 0.6);
  noise += Noise{.variance = 0.0, .luminance = 0.0, .pixels = 12};
  EXPECT_DOUBLE_EQ(noise.error(0.0), 0.15 / 0.125);
  EXPECT_EQ(Noise{}.error(0.1), 0.0);
}

TEST(Noise, floor_is_a_hundredth_of_what_is_shown_as_white) {
  // A stop more shows half as much light as white.
  EXPECT_DOUBLE_EQ(noise_floor(0.0), 0.01);
  EXPECT_DOUBLE_EQ(noise_floor(2.0), 0.0025);
  EXPECT_DOUBLE_EQ(noise_floor(-1.0), 0.02);
}

TEST(Variance, is_right_where_light_changes_smoothly) {
  // A plane under a sky that changes with the elevation: nothing but smooth functions of the numbers drawn.
  Scene scene = test::dark_scene(test::camera_at({0, 0, 0.5}, {0, 0, 0}, 10.0, 16), 1, 0);
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(1.0f)}}};
  scene.sky = GradientSky{Rgb(0.0f), Rgb(1.0f)};
  expect_right(scene, nullptr, {2, 3, 8, 16, 32, 50, 128});
}

TEST(Variance, is_right_at_edges) {
  Scene scene = test::dark_scene(test::camera_at({0, -4, 0}, {0, 0, 0}, 30.0, 16), 1, 0);
  scene.objects = {Sphere{{0, 0, 0}, 0.7, Emissive{Rgb(1.0f)}},
                   Sphere{{0.9, 0, 0.5}, 0.3, Emissive{Rgb(3.0f)}}};
  expect_right(scene, nullptr, {8, 16, 32, 50});
}

TEST(Variance, is_right_for_paths_over_a_cloud_in_sun_and_sky) {
  test::Random random("heap of points");
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < 2000; ++i) positions.push_back(random.in_cube() * glm::dvec3(2, 2, 0.3));
  const LoadedCloud cloud = test::loaded(positions, 0.08);
  Scene scene = test::dark_scene(test::camera_at({0, -6, 4}, {0, 0, 0}, 40.0, 16), 1, 4);
  scene.cloud.emplace();
  scene.sky = GradientSky{};
  scene.sun.emplace();
  expect_right(scene, &cloud, {16, 32, 50});
}

/// A lamp, rough metal and glass in a weak sky.
Scene lamp_scene() {
  Scene scene = test::dark_scene(test::camera_at({0, -6, 3}, {0, 0, 0.5}, 40.0, 16), 1, 4);
  scene.objects = {GroundPlane{0.0, Lambertian{Rgb(0.4f)}}, Sphere{{1, 0, 1}, 0.7, Dielectric{1.5}},
                   Sphere{{-1, 0, 1}, 0.7, Metal{Rgb(0.9f), 0.3}},
                   Sphere{{0, 1, 3}, 0.3, Emissive{Rgb(5.0f)}}};
  scene.sky = ConstantSky{Rgb(0.2f)};
  return scene;
}

TEST(Variance, is_right_for_lamps_metal_and_glass) {
  expect_right(lamp_scene(), nullptr, {8, 16, 32, 50});
}

TEST(Variance, is_right_under_a_target_too_and_the_image_is_hardly_darker) {
  Scene scene = lamp_scene();
  scene.camera = pinhole_from_fov(48, 16, 25.0, look_at({0, -6, 3}, {0, 0, 0.5}));
  constexpr double k_target = 0.06;
  RenderStatistics statistics;
  scene.render.samples = 1000;
  render(scene, nullptr, {.target_noise = k_target}, &statistics);
  ASSERT_LT(statistics.most_samples, 1000);
  ASSERT_GT(statistics.most_samples, 32);
  const Spread stopped = spread_of(scene, nullptr, 1000, k_target);
  EXPECT_GT(stopped.ratio(), k_most_below);
  EXPECT_LT(stopped.ratio(), k_most_above);
  const Spread fixed = spread_of(scene, nullptr, 64);
  EXPECT_NEAR(stopped.mean, fixed.mean, 0.02 * k_target * fixed.mean);
}

}  // namespace
}  // namespace alidade
