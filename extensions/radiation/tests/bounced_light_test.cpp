// SPDX-License-Identifier: MIT
// One bounce of light, in places whose form factors are known on paper.
#include "extensions/radiation/bounced_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/error.h"
#include "extensions/radiation/sky_patches.h"
#include "extensions/radiation/tests/radiation_of_cloud.h"
#include "geo/earth.h"
#include "mesh/triangle_tree.h"
#include "tests/visibility/sampled_shapes.h"

namespace alidade::test {

using namespace geo;
using namespace visibility;

namespace {

constexpr double k_pi = std::numbers::pi;
const glm::dvec3 k_up(0.0, 0.0, 1.0);

/// An even sky that gives open level ground 100 Wh/m2.
EnergyLight even_sky() {
  EnergyLight light;
  for (int patch = 0; patch < k_sky_patches; ++patch) {
    LightSums sums;
    sums.diffuse = 100.0 / k_pi * direction_integral(sky_patch(patch));
    light.bins.push_back({line_into_patch(patch), {{0, sums}}});
  }
  light.open.push_back({0.0, glm::dvec3(0.0), glm::dvec3(0.0, 0.0, 100.0)});
  return light;
}

/// The sun alone, an hour of 1000 W/m2.
EnergyLight sun_at(double azimuth, double elevation) {
  return energy_light(std::vector<LitStep>{{azimuth, elevation, 1.0, 1000.0}}, 1, {.has_sky = false});
}

double reflected(const Occluders& occluders, const SkyTarget& target, const EnergyLight& light,
                 const RadiationOptions& options) {
  Radiation answer;
  radiation(occluders, std::span(&target, 1), light, options, std::span(&answer, 1));
  return answer.reflected;
}

RadiationOptions facing(const glm::dvec3& normal, double albedo = 1.0) {
  return {.normal = normal, .albedo = albedo, .bounces = 1};
}

/// Form factor from a small receiver to a rectangle a high and b wide at a right angle to it, whose lower
/// corner is c away in the direction of its normal. Howell, A Catalog of Radiation Heat Transfer
/// Configuration Factors.
double beside_rectangle(double a, double b, double c) {
  const double x = a / b, y = c / b, root = std::hypot(x, y);
  return (std::atan(1.0 / y) - y / root * std::atan(1.0 / root)) / (2.0 * k_pi);
}

/// Form factor from a small receiver to a rectangle that it faces, whose corner is c away on its normal.
double before_rectangle(double a, double b, double c) {
  const double x = a / c, y = b / c, with_x = std::sqrt(1.0 + x * x), with_y = std::sqrt(1.0 + y * y);
  return (x / with_x * std::atan(y / with_x) + y / with_y * std::atan(x / with_y)) / (2.0 * k_pi);
}

/// A wall in the north at y = 0, from x = -20 to 20 and to z = 12, of points.
Points wall(double bottom = 0.0) {
  Points points;
  add_rectangle(points, {-20, 0, bottom}, {40, 0, 0}, {0, 0, 12.0 - bottom}, 0.25);
  return points;
}

TEST(BouncedLight, on_level_ground_before_a_sunlit_wall_is_its_form_factor) {
  const Occluders occluders(octree_of(wall()), {});
  const double of_wall = 1000.0 * std::cos(30.0 * k_pi / 180.0);
  for (const double distance : {4.0, 8.0, 12.0}) {
    const SkyTarget target = target_in_open({{0.0, -distance, 0.0}});
    const double expected = 0.6 * of_wall * 2.0 * beside_rectangle(12.0, 20.0, distance);
    EXPECT_NEAR(reflected(occluders, target, sun_at(180.0, 30.0), facing(k_up, 0.6)), expected,
                0.02 * 0.6 * of_wall)
        << distance;
  }
}

TEST(BouncedLight, of_a_receiver_that_faces_a_sunlit_wall_is_that_of_the_wall_and_the_ground) {
  const Occluders occluders(octree_of(wall(-12.0)), {});
  const double of_wall = 1000.0 * std::cos(30.0 * k_pi / 180.0),
               of_ground = 1000.0 * std::sin(30.0 * k_pi / 180.0);
  for (const double distance : {4.0, 10.0}) {
    const double quarter = before_rectangle(20.0, 12.0, distance),
                 expected = 0.6 * (4.0 * quarter * of_wall + (0.5 - 2.0 * quarter) * of_ground);
    const SkyTarget target = target_in_open({{0.0, -distance, 0.0}});
    EXPECT_NEAR(reflected(occluders, target, sun_at(180.0, 30.0), facing({0, 1, 0}, 0.6)), expected,
                0.035 * 0.6 * of_wall)
        << distance;
  }
}

TEST(BouncedLight, comes_from_the_side_of_a_thin_wall_that_the_receiver_sees) {
  const Occluders occluders(octree_of(wall()), {});
  const EnergyLight light = sun_at(180.0, 30.0);
  EXPECT_EQ(reflected(occluders, target_in_open({{0.0, 4.0, 1.0}}), light, facing(k_up)), 0.0);
  EXPECT_GT(reflected(occluders, target_in_open({{0.0, -4.0, 1.0}}), light, facing(k_up)), 100.0);
}

/// A street along x, 10 m wide and with walls 10 m high.
constexpr double k_width = 10.0, k_height = 10.0;

Points street() {
  Points points;
  for (const double y : {-0.5 * k_width, 0.5 * k_width})
    add_rectangle(points, {-100, y, 0}, {200, 0, 0}, {0, 0, k_height}, 0.5);
  add_rectangle(points, {-100, -0.5 * k_width, 0}, {200, 0, 0}, {0, k_width, 0}, 0.5);
  return points;
}

/// Reflected light in the middle of the street's floor, per albedo: the sky that each strip of the endless
/// walls sees, (1 - sin a) / 2 with the elevation a of the other wall, times the form factor of the strip,
/// half the difference of the sines of its angles from the zenith (Hottel's crossed strings).
double on_floor_of_street() {
  constexpr int k_strips = 100000;
  double sum = 0.0;
  for (int i = 0; i < k_strips; ++i) {
    const double low = k_height * i / k_strips, high = k_height * (i + 1) / k_strips,
                 above = k_height - 0.5 * (low + high);
    const auto sine = [](double height) { return 0.5 * k_width / std::hypot(0.5 * k_width, height); };
    sum += 100.0 * 0.5 * (1.0 - above / std::hypot(above, k_width)) * 0.5 * (sine(low) - sine(high));
  }
  return 2.0 * sum;
}

TEST(BouncedLight, on_the_floor_of_a_long_street_under_an_even_sky_is_that_of_its_walls) {
  const Occluders occluders(octree_of(street()), {});
  double sum = 0.0;
  int count = 0;
  for (double x = -5.0; x <= 5.0; x += 1.0, ++count)
    sum += reflected(occluders, target_in_open({{x + 0.1, 0.0, 0.05}}), even_sky(), facing(k_up, 0.5));
  EXPECT_NEAR(sum / count, 0.5 * on_floor_of_street(), 0.02 * 0.5 * on_floor_of_street() + 0.3);
}

TEST(BouncedLight, of_points_without_a_surface_is_a_quarter_of_what_faces_the_sun) {
  // A wall whose points are spheres: two quarters of a sphere's light reach a receiver, wherever the sun is.
  const Occluders occluders(octree_of(wall()), {.shape = OccluderShape::sphere});
  const double share = 2.0 * beside_rectangle(12.0, 20.0, 4.0);
  const SkyTarget target = target_in_open({{0.0, -4.0, 0.0}});
  EXPECT_NEAR(reflected(occluders, target, sun_at(180.0, 30.0), facing(k_up)), 250.0 * share, 0.03 * 250.0);
}

TEST(BouncedLight, where_nothing_stands_around_is_that_of_the_ground) {
  Points points;
  add_rectangle(points, {-1000, -1000, -50}, {1, 0, 0}, {0, 1, 0}, 0.25);
  const Occluders occluders(octree_of(points), {});
  const SkyTarget target = target_in_open({{0.0, 0.0, 10.0}});
  for (const double tilt : {0.0, 20.0, 55.0, 90.0}) {
    RadiationOptions options = facing(tilted_normal(tilt, 140.0), 0.3);
    const double with = reflected(occluders, target, even_sky(), options);
    options.bounces = 0;
    EXPECT_NEAR(with, reflected(occluders, target, even_sky(), options), 1e-4) << tilt;
  }
}

TEST(BouncedLight, within_an_even_enclosure_is_albedo_times_its_irradiance_whatever_the_tilt) {
  // A closed tent of a mesh, which reflects as open level ground.
  TriangleMesh tent;
  tent.vertices = {{-9, -9, -9}, {9, -8, -9}, {0, 9, -9}, {0, 0, 12}};
  tent.triangles = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  OccluderOptions blocking;
  blocking.mesh = std::make_shared<const TriangleTree>(std::move(tent));
  const Occluders occluders(build(PointCloud()), blocking);
  const SkyTarget target = target_in_open({{0.0, 0.0, -2.0}});
  for (const double tilt : {0.0, 33.0, 71.0, 90.0})
    EXPECT_NEAR(reflected(occluders, target, even_sky(), facing(tilted_normal(tilt, 77.0), 0.4)), 40.0, 1e-4);
}

TEST(BouncedLight, is_never_more_than_albedo_times_what_comes_in) {
  // A box without a lid: outside its walls nothing is lit but what the normals point to.
  Points points;
  std::vector<glm::vec3> normals;
  const auto add = [&](const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v) {
    add_rectangle(points, corner, u, v, 0.8);
    normals.resize(points.size(), glm::vec3(glm::normalize(glm::cross(u, v))));
  };
  add({-10, -10, 0}, {20, 0, 0}, {0, 20, 0});
  add({-10, 10, 0.4}, {20, 0, 0}, {0, 0, 8});
  add({10, -10, 0.4}, {-20, 0, 0}, {0, 0, 8});
  add({10, 10, 0.4}, {0, -20, 0}, {0, 0, 8});
  add({-10, -10, 0.4}, {0, 20, 0}, {0, 0, 8});
  const Occluders occluders(octree_of(points), {});
  const std::vector<LitStep> steps{{180.0, 50.0, 2.0, 800.0, 100.0}, {120.0, 20.0, 1.0, 500.0, 60.0}};
  const EnergyLight light = energy_light(steps, 1, {});
  const std::vector<Radiation> answers =
      point_radiation(occluders, normals, light, {.albedo = 0.7, .bounces = 1});
  float most = 0.0f;
  double in = 0.0, out = 0.0;
  for (const Radiation& answer : answers) {
    most = std::max(most, answer.beam + answer.diffuse);
    in += answer.beam + answer.diffuse;
    out += answer.reflected;
  }
  for (const Radiation& answer : answers) {
    EXPECT_GE(answer.reflected, 0.0f);
    EXPECT_LE(answer.reflected, 0.7f * most * 1.0001f);
  }
  EXPECT_GT(out, 0.2 * 0.7 * in) << "the walls and the floor see each other";
  EXPECT_LT(out, 0.7 * in);
}

/// A square with a wall along its north side and a bush without surfaces.
Points yard() {
  Points points;
  add_rectangle(points, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, 0.5);
  add_rectangle(points, {-5, 5, 0}, {10, 0, 0}, {0, 0, 4}, 0.5);
  for (int i = 0; i < 60; ++i)
    points.emplace_back(2.0 + std::cos(2.4 * i) * 0.02 * i, -2.0 + std::sin(2.4 * i) * 0.02 * i,
                        0.5 + 0.05 * (i * 7 % 31));
  return points;
}

EnergyLight two_periods() {
  const std::vector<LitStep> steps{{180.0, 50.0, 2.0, 800.0, 100.0, 1367.0, 0},
                                   {120.0, 20.0, 1.0, 500.0, 60.0, 1367.0, 1}};
  return energy_light(steps, 2, {});
}

TEST(PointSunHours, with_a_bounce_are_those_of_single_targets_and_change_only_reflected_light) {
  const Points points = yard();
  const Occluders occluders(octree_of(points), {});
  const EnergyLight light = two_periods();
  for (const bool is_tilted : {false, true}) {
    RadiationOptions options{.albedo = 0.3};
    if (is_tilted) options.normal = tilted_normal(40.0, 200.0);
    const std::vector<Radiation> without = point_radiation(occluders, {}, light, options);
    options.bounces = 1;
    const std::vector<Radiation> with = point_radiation(occluders, {}, light, options);
    ASSERT_EQ(with.size(), 2 * points.size());
    for (std::size_t i = 0; i < with.size(); ++i) {
      ASSERT_EQ(with[i].hours, without[i].hours) << i;
      ASSERT_EQ(with[i].beam, without[i].beam) << i;
      ASSERT_EQ(with[i].diffuse, without[i].diffuse) << i;
    }
    for (std::size_t id = 0; id < points.size(); id += 47) {
      std::vector<SkyTarget> target{target_on_point(occluders, id, points[id], {})};
      find_open_sides(occluders, 64, target);
      std::vector<Radiation> alone(2);
      radiation(occluders, target, light, options, alone);
      EXPECT_EQ(with[2 * id].reflected, alone[0].reflected) << id;
      EXPECT_EQ(with[2 * id + 1].reflected, alone[1].reflected) << id;
    }
  }
}

TEST(PointSunHours, with_a_bounce_are_the_same_when_the_run_was_stopped_between) {
  Points points = yard();
  add_rectangle(points, {-15, -18, 0}, {30, 0, 0}, {0, 12, 0}, 0.5);
  const Occluders occluders(octree_of(points), {});
  EnergyLight light = sun_at(180.0, 40.0);
  // Lights that nothing faces: they make the blocks small.
  light.bins.resize(8192, {{0.0, 0.0, -1.0}, {}});
  const RadiationOptions options{.max_distance = 6.0, .bounces = 1};
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "bounced_light.state";
  std::filesystem::remove(file);
  const Fingerprint fingerprint{{"command", "sun"}};
  {
    PartCheckpoint parts({.file = file, .interval = 1e-3}, fingerprint);
    const Progress half = [](std::uint64_t done, std::uint64_t total) { return 2 * done < total; };
    EXPECT_THROW(point_radiation(occluders, {}, light, options, {half, &parts}), Cancelled);
  }
  PartCheckpoint parts({.file = file, .resume = true}, fingerprint);
  EXPECT_GT(parts.finished(), 0u);
  const std::vector<Radiation> cut = point_radiation(occluders, {}, light, options, {{}, &parts}),
                               whole = point_radiation(occluders, {}, light, options);
  parts.remove();
  ASSERT_EQ(cut.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) ASSERT_EQ(cut[i].reflected, whole[i].reflected) << i;
}

TEST(GroundSunHours, with_a_bounce_are_brighter_before_a_sunlit_wall) {
  Points points = wall();
  add_rectangle(points, {-20, -24, 0}, {40, 0, 0}, {0, 24, 0}, 0.25);
  const Occluders occluders(octree_of(points), {});
  const Ground ground = make_ground(occluders.octree(), {}, {.cell_size = 0.5, .reach = 1.0});
  RasterGrid grid;
  grid.north_west = {-1.0, -2.0};
  grid.cell_size = 2.0;
  grid.columns = 1;
  grid.rows = 8;
  const RadiationOptions options{.receiver = SkyReceiver::horizontal, .albedo = 0.6, .bounces = 1};
  const std::vector<Radiation> map =
      ground_radiation(occluders, ground, grid, 0.0, sun_at(180.0, 30.0), options);
  const double of_wall = 1000.0 * std::cos(30.0 * k_pi / 180.0);
  for (int row = 0; row < grid.rows; ++row) {
    const double distance = 3.0 + 2.0 * row;
    EXPECT_NEAR(map[static_cast<std::size_t>(row)].reflected,
                0.6 * of_wall * 2.0 * beside_rectangle(12.0, 20.0, distance), 0.02 * 0.6 * of_wall)
        << distance;
  }
}

TEST(BouncedLight, with_other_numbers_than_0_or_1_is_an_error) {
  const Occluders occluders(octree_of(wall()), {});
  const SkyTarget target = target_in_open({{0.0, -4.0, 0.0}});
  for (const int bounces : {-1, 2}) {
    RadiationOptions options;
    options.bounces = bounces;
    EXPECT_THROW(reflected(occluders, target, even_sky(), options), Error) << bounces;
  }
  EXPECT_THROW(BouncedLight(occluders, even_sky(), {}, -1.0), Error);
  EXPECT_THROW(BouncedLight(occluders, even_sky(), {}, NAN), Error);
}

}  // namespace
}  // namespace alidade::test
