// SPDX-License-Identifier: MIT
// Horizons and sky-view factors over elevation rasters: against exact ones of the bilinear surface
// (exact_terrain.h), and against formulas of a dome, a bowl, a ridge and a valley.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>

#include "tests/support/absent_data.h"
#include "tests/support/random.h"
#include "tests/visibility/ascii_grid.h"
#include "tests/visibility/exact_terrain.h"
#include "visibility/horizon/horizon.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

constexpr double k_degree = std::numbers::pi / 180.0;
/// The program's horizon is the highest blocked of lines this far apart.
constexpr double k_resolution = HorizonOptions().resolution;
constexpr double k_step = 2.0;  ///< between azimuths, for the sake of time
/// Directions of `alidade visibility horizon`.
constexpr int k_directions = 4096;

double degrees(double radians) {
  return radians / k_degree;
}

/// Heights by x and y in cells from the middle one, `half` to every side.
Raster<float> shaped(int half, double cell, const std::function<double(double, double)>& height) {
  const int size = 2 * half + 1;
  Raster<float> heights({{690000.0, 5325000.0}, cell, size, size}, 0.0f);
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column)
      heights.at(column, row) =
          static_cast<float>(500.0 + height(cell * (column - half), cell * (half - row)));
  return heights;
}

/// Waves and steps of all sizes.
Raster<float> rough(int half, Random& random) {
  return shaped(half, 10.0, [&](double x, double y) {
    return 60.0 * std::sin(0.011 * x) * std::cos(0.008 * y) + 9.0 * std::sin(0.09 * x + 0.04 * y) +
           random.between(0.0, 4.0);
  });
}

/// How far a horizon and its sky are from the exact ones.
struct Differences {
  double horizon = 0.0;                ///< largest, degrees
  double above_line = 0.0, sky = 0.0;  ///< largest of sky_above() and of sky_shares()
};

/// Of an eye over a raster: no horizon is above the exact one or more than the resolution below it. On the
/// surface, lines that are less than a millimetre below it count as lying on it: the horizon is at least that
/// of an eye so much higher.
void expect_exact(const Raster<float>& heights, const glm::dvec3& eye, bool is_on_surface,
                  Differences& differences) {
  const Occluders occluders = occluders_of(heights);
  const std::vector<HorizonDirection> line = horizon(occluders, {eye}, {.step = k_step});
  for (const HorizonDirection& direction : line) {
    const double exact = exact_horizon(heights, eye, direction.azimuth);
    ASSERT_TRUE(direction.elevation) << direction.azimuth;
    EXPECT_LE(*direction.elevation, exact + 1e-4) << direction.azimuth;
    const glm::dvec3 contact(0.0, 0.0, is_on_surface ? k_mesh_contact : 0.0);
    EXPECT_GE(*direction.elevation,
              exact_horizon(heights, eye + contact, direction.azimuth) - k_resolution - 1e-4)
        << direction.azimuth;
    differences.horizon = std::max(differences.horizon, std::fabs(*direction.elevation - exact));
  }
  const double exact = exact_sky_view(heights, eye, 720);
  differences.above_line =
      std::max(differences.above_line, std::fabs(sky_above(line).cosine_weighted - exact));
  differences.sky = std::max(differences.sky,
                             std::fabs(sky_shares(occluders, {eye}, k_directions).cosine_weighted - exact));
}

void expect_exact(const char* name, const Raster<float>& heights, std::initializer_list<glm::dvec2> cells,
                  double eye_height) {
  Differences differences;
  for (const glm::dvec2& cell : cells)
    expect_exact(heights, above(heights, cell, eye_height), eye_height == 0.0, differences);
  std::printf(
      "%s, eye %g m above: farthest from the exact horizon %.4f degrees; sky above the line %.5f, sky %.5f\n",
      name, eye_height, differences.horizon, differences.above_line, differences.sky);
  if (eye_height > 0.0) {
    EXPECT_LE(differences.horizon, 0.05);
  }
  EXPECT_LE(differences.above_line, 0.005);
  EXPECT_LE(differences.sky, 0.005);
}

TEST(HorizonTerrain, of_rough_ground_is_the_exact_one) {
  Random random;
  const Raster<float> heights = rough(60, random);
  for (const double height : {0.05, 1.7, 40.0})
    expect_exact("rough ground", heights, {{60, 60}, {20.3, 91.7}, {100, 15.5}, {3, 3}}, height);
  expect_exact("rough ground", heights, {{60, 60}}, 0.0);
}

TEST(HorizonTerrain, of_test_data_of_r_viewshed_is_the_exact_one) {
  const std::optional<Raster<float>> elevation = elevation_of_r_viewshed();
  if (!elevation) GTEST_SKIP() << absent("grass_elevation.ascii of ../shared/data/viewshed", 4);
  const Raster<float>& heights = *elevation;
  for (const double height : {0.05, 1.7, 40.0})
    expect_exact("elevation", heights, {{99, 81}, {40, 100}, {110.4, 40.2}}, height);
  expect_exact("elevation", heights, {{99, 81}}, 0.0);
}

/// The horizon against a formula in the azimuths where that has an answer, to a twentieth of a degree.
void expect_formula(const char* name, const Raster<float>& heights, const glm::dvec3& eye,
                    const std::function<std::optional<double>(double)>& formula) {
  const std::vector<HorizonDirection> line = horizon(occluders_of(heights), {eye}, {.step = k_step});
  double farthest = 0.0;
  int asked = 0;
  for (const HorizonDirection& direction : line) {
    const std::optional<double> expected = formula(direction.azimuth);
    if (!expected) continue;
    ++asked;
    ASSERT_TRUE(direction.elevation) << direction.azimuth;
    EXPECT_NEAR(*direction.elevation, *expected, 0.05) << direction.azimuth;
    farthest = std::max(farthest, std::fabs(*direction.elevation - *expected));
  }
  EXPECT_GT(asked, 20);
  std::printf("%s: farthest from its formula %.4f degrees, in %d azimuths\n", name, farthest, asked);
}

void expect_sky(const char* name, const Raster<float>& heights, const glm::dvec3& eye, double expected) {
  const Occluders occluders = occluders_of(heights);
  const double above_line = sky_above(horizon(occluders, {eye}, {.step = k_step})).cosine_weighted,
               sky = sky_shares(occluders, {eye}, k_directions).cosine_weighted;
  EXPECT_NEAR(above_line, expected, 0.005) << name;
  EXPECT_NEAR(sky, expected, 0.005) << name;
  std::printf("%s: sky %.5f, above the line %.5f, sky %.5f\n", name, expected, above_line, sky);
}

TEST(HorizonTerrain, of_a_dome_is_its_tangent) {
  // Half a sphere of 150 m, 300 m east of an eye 2 m above its base.
  constexpr double k_radius = 150.0, k_distance = 300.0, k_eye = 2.0;
  const Raster<float> dome = shaped(500, 1.0, [](double x, double y) {
    return std::sqrt(std::max(k_radius * k_radius - (x - k_distance) * (x - k_distance) - y * y, 0.0));
  });
  expect_formula("dome", dome, above(dome, {500, 500}, k_eye), [](double azimuth) -> std::optional<double> {
    const double off = (azimuth - 90.0) * k_degree;
    if (std::fabs(off) > 22.0 * k_degree) return {};
    const double circle = std::sqrt(k_radius * k_radius - std::pow(k_distance * std::sin(off), 2.0));
    const double along = k_distance * std::cos(off);
    return degrees(std::asin(circle / std::hypot(along, k_eye)) - std::atan(k_eye / along));
  });
}

/// Half a sphere's lower part, sunk into a plane at 0: 200 m to the rim, 80 m deep.
constexpr double k_rim = 200.0, k_depth = 80.0;

Raster<float> bowl() {
  constexpr double k_radius = (k_rim * k_rim + k_depth * k_depth) / (2.0 * k_depth);
  return shaped(450, 0.5, [](double x, double y) {
    const double square = std::min(x * x + y * y, k_rim * k_rim);
    return k_radius - k_depth - std::sqrt(k_radius * k_radius - square);
  });
}

TEST(HorizonTerrain, of_a_bowl_is_its_rim) {
  const Raster<float> heights = bowl();
  constexpr double k_eye = 2.0;
  const double top = 500.0;
  for (const double east : {0.0, 70.0}) {
    const glm::dvec3 eye = above(heights, {450.0 + 2.0 * east, 450.0}, k_eye);
    expect_formula("bowl", heights, eye, [&](double azimuth) -> std::optional<double> {
      const double along = east * std::sin(azimuth * k_degree), across = east * std::cos(azimuth * k_degree);
      return degrees(std::atan2(top - eye.z, -along + std::sqrt(k_rim * k_rim - across * across)));
    });
  }
  // cos^2 of one elevation all round.
  constexpr double k_high = k_depth - k_eye;
  expect_sky("bowl", heights, above(heights, {450, 450}, k_eye),
             k_rim * k_rim / (k_rim * k_rim + k_high * k_high));
}

TEST(HorizonTerrain, of_a_ridge_is_its_crest) {
  // 90 m high, 200 m north of the eye, as long as the raster, with flanks of one in one.
  constexpr double k_height = 90.0, k_distance = 200.0;
  const Raster<float> ridge =
      shaped(400, 1.0, [](double, double y) { return std::max(k_height - std::fabs(y - k_distance), 0.0); });
  for (const double height : {2.0, 30.0}) {
    expect_formula("ridge", ridge, above(ridge, {400, 400}, height),
                   [&](double azimuth) -> std::optional<double> {
                     const double off = std::remainder(azimuth, 360.0);
                     if (std::fabs(off) > 60.0) return {};
                     return degrees(std::atan((k_height - height) * std::cos(off * k_degree) / k_distance));
                   });
  }
}

TEST(HorizonTerrain, of_a_valley_are_its_slopes) {
  // Two slopes of one in two meet below the eye.
  constexpr double k_slope = 0.5;
  const Raster<float> valley = shaped(60, 5.0, [](double x, double) { return k_slope * std::fabs(x); });
  const glm::dvec3 eye = above(valley, {60, 60}, 0.0);
  expect_formula("valley", valley, eye, [](double azimuth) -> std::optional<double> {
    return degrees(std::atan(k_slope * std::fabs(std::sin(azimuth * k_degree))));
  });
  expect_sky("valley", valley, eye, std::cos(std::atan(k_slope)));
}

TEST(HorizonTerrain, a_map_of_the_sky_is_that_of_exact_horizons) {
  constexpr int k_apart = 4;
  Random random;
  const Raster<float> heights = rough(20, random);
  const Occluders occluders = occluders_of(heights);
  const Ground ground{TerrainSurface(heights)};
  Raster<double> exact(heights.grid, 0.0);
  for (int row = 0; row < heights.grid.rows; row += k_apart)
    for (int column = 0; column < heights.grid.columns; column += k_apart)
      exact.at(column, row) = exact_sky_view(heights, above(heights, glm::dvec2(column, row), 0.0), 360);
  for (const auto& [directions, limit] : {std::pair(128, 0.001), {1024, 0.0005}}) {
    const Raster<float> map =
        ground_sky_views(occluders, ground, heights.grid, 0.0,
                         {.directions = directions, .receiver = SkyReceiver::horizontal});
    double squares = 0.0, largest = 0.0;
    int count = 0;
    for (int row = 0; row < heights.grid.rows; row += k_apart) {
      for (int column = 0; column < heights.grid.columns; column += k_apart) {
        const double difference = map.at(column, row) - exact.at(column, row);
        squares += difference * difference;
        largest = std::max(largest, std::fabs(difference));
        ++count;
      }
    }
    EXPECT_LE(largest, limit) << directions;
    std::printf("map of the sky, %d directions: %d cells differ by %.4f (root mean square), %.4f (largest)\n",
                directions, count, std::sqrt(squares / count), largest);
  }
}

}  // namespace
}  // namespace alidade::test
