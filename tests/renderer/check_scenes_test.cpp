// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <numbers>

#include "camera/camera.h"
#include "cloud/ply/write_ply.h"
#include "renderer/read_scene.h"
#include "renderer/render.h"

// Scenes whose images are known on paper; the scene files contain the derivations.

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

Scene check_scene(const std::string& name) {
  return read_scene(std::filesystem::path(ALIDADE_SOURCE_FOLDER) / "scenes/check" / (name + ".json"));
}

glm::dvec3 mean_color(const Film& film) {
  glm::dvec3 sum(0.0);
  for (const Rgb& color : film.color) sum += glm::dvec3(color);
  return sum / static_cast<double>(film.color.size());
}

void expect_mean(const std::string& name, const glm::dvec3& paper) {
  const glm::dvec3 mean = mean_color(render(check_scene(name), nullptr));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(mean[i] / paper[i], 1.0, 0.005) << name << " channel " << i;
}

TEST(CheckScenesTest, furnace_within_half_a_percent) {
  expect_mean("furnace", {1.0 / 2, 1.0 / 5, 1.0 / 17});
}

TEST(CheckScenesTest, sun_on_plane_within_half_a_percent) {
  expect_mean("sun_on_plane", {0.9, 0.5, 0.1});
}

TEST(CheckScenesTest, sky_on_plane_within_half_a_percent) {
  expect_mean("sky_on_plane", {0.4, 0.48, 0.6});
}

TEST(CheckScenesTest, white_furnace_makes_lossless_spheres_invisible) {
  const Film film = render(check_scene("white_furnace"), nullptr);
  int met = 0;
  for (std::size_t i = 0; i < film.color.size(); ++i) {
    met += film.id[i] != 0;
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(film.color[i][c], 1.0, 1e-4) << "pixel " << i;
  }
  EXPECT_GT(met, 300) << "the spheres are in the picture";
}

/// Evenly spread points: a Fibonacci lattice (the golden angle around the axis, equal steps of z).
PointCloud points_on_sphere(std::int64_t count, double radius, const glm::dvec3& center) {
  PointCloud cloud;
  cloud.lattice = {.scale = glm::dvec3(1e-4), .offset = center};
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (std::int64_t i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double across = std::sqrt(1.0 - z * z), angle = golden_angle * static_cast<double>(i);
    const glm::dvec3 steps =
        glm::dvec3(across * std::cos(angle), across * std::sin(angle), z) * (radius / 1e-4);
    cloud.positions.push_back({static_cast<std::int32_t>(std::lround(steps.x)),
                               static_cast<std::int32_t>(std::lround(steps.y)),
                               static_cast<std::int32_t>(std::lround(steps.z))});
  }
  return cloud;
}

/// Where a ray from outside meets a sphere; empty if it does not.
std::optional<double> distance_to_sphere(const Ray& ray, const glm::dvec3& center, double radius) {
  const glm::dvec3 to_center = center - ray.origin;
  const double middle = glm::dot(to_center, ray.direction);
  const double half_sq = radius * radius - glm::dot(to_center, to_center) + middle * middle;
  if (half_sq < 0.0) return {};
  return middle - std::sqrt(half_sq);
}

TEST(CheckScenesTest, sphere_of_points_is_seen_between_the_exact_spheres_and_loses_no_light) {
  const glm::dvec3 center(690000, 5325000, 500);
  Scene scene = check_scene("sphere_of_points");
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("sphere_of_points_" + std::to_string(::getpid()) + ".ply");
  write_ply(file, points_on_sphere(200000, 10.0, center), {.overwrite = true, .progress = {}});
  scene.cloud->files = {file};
  const LoadedCloud cloud = load_cloud(*scene.cloud);
  std::filesystem::remove(file);
  EXPECT_EQ(cloud.radius, 0.15);
  const Film film = render(scene, &cloud);
  int seen = 0;
  for (int y = 0; y < film.height; ++y) {
    for (int x = 0; x < film.width; ++x) {
      const std::size_t i = film.index(x, y);
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(film.color[i][c], 1.0, 1e-3) << x << " " << y;
      const Ray ray = camera_ray(*scene.camera, {x + 0.5, y + 0.5});
      const auto outer = distance_to_sphere(ray, center, 10.15),
                 inner = distance_to_sphere(ray, center, 10.1265);
      EXPECT_TRUE(outer || film.id[i] == 0) << x << " " << y;
      if (!inner) continue;
      ++seen;
      ASSERT_NE(film.id[i], 0u) << x << " " << y;
      // Positions are rounded to 0.1 mm, distances to float.
      EXPECT_GE(film.distance[i], *outer - 2e-4) << x << " " << y;
      EXPECT_LE(film.distance[i], *inner + 2e-4) << x << " " << y;
    }
  }
  EXPECT_GT(seen, 800);
}

}  // namespace
}  // namespace alidade::test
