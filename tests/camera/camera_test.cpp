// SPDX-License-Identifier: MIT
#include "camera/camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "tests/support/random.h"

namespace alidade {

using namespace camera;

namespace {

TEST(Camera, film_position_survives_the_way_to_the_world_and_back) {
  test::Random random;
  for (int i = 0; i < 2000; ++i) {
    Camera camera = pinhole_from_fov(600, 400, random.between(10.0, 120.0),
                                     look_at(random.in_cube(), random.in_cube() * 10.0, random.direction()));
    camera.fx *= random.between(0.5, 2.0);
    camera.cx += random.between(-100.0, 100.0);
    const glm::dvec2 film(random.between(0.0, 600.0), random.between(0.0, 400.0));
    const Ray ray = camera_ray(camera, film);
    ASSERT_NEAR(glm::length(ray.direction), 1.0, 1e-15);
    ASSERT_EQ(ray.t_min, 0.0);
    const auto back = project_to_film(camera, ray.position(random.between(1.0, 50.0)));
    ASSERT_TRUE(back);
    ASSERT_NEAR(back->x, film.x, 1e-9);
    ASSERT_NEAR(back->y, film.y, 1e-9);
  }
}

TEST(Camera, nothing_is_projected_from_behind) {
  const Camera camera = pinhole_from_fov(10, 10, 90.0, look_at({0, 0, 0}, {0, 1, 0}));
  EXPECT_FALSE(project_to_film(camera, {0.0, -1.0, 0.0}));
  EXPECT_FALSE(project_to_film(camera, {1.0, 0.0, 0.0}));
}

TEST(Camera, look_at_is_a_rotation_with_up_towards_the_top) {
  const CameraPose pose = look_at({1, 2, 3}, {4, 6, 3});
  EXPECT_NEAR(glm::length(pose.forward - glm::dvec3(0.6, 0.8, 0.0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(pose.right - glm::dvec3(0.8, -0.6, 0.0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::length(pose.down - glm::dvec3(0.0, 0.0, -1.0)), 0.0, 1e-15);
}

TEST(Camera, field_of_view_reaches_the_middle_of_the_top_edge) {
  const Camera camera = pinhole_from_fov(600, 400, 50.0, look_at({0, 0, 0}, {0, 1, 0}));
  const Ray ray = camera_ray(camera, {300.0, 0.0});
  EXPECT_NEAR(std::atan2(ray.direction.z, ray.direction.y), 25.0 * std::numbers::pi / 180.0, 1e-14);
  EXPECT_NEAR(camera_ray(camera, {300.0, 200.0}).direction.y, 1.0, 1e-15);
}

TEST(Camera, impossible_views_are_errors) {
  EXPECT_THROW(look_at({1, 2, 3}, {1, 2, 3}), Error);
  EXPECT_THROW(look_at({0, 0, 0}, {0, 0, 5}), Error);
  EXPECT_THROW(look_at({0, 0, 0}, {0, 1, 0}, {0, 0, 0}), Error);
  EXPECT_THROW(look_at({0, NAN, 0}, {0, 1, 0}), Error);
  const CameraPose pose = look_at({0, 0, 0}, {0, 1, 0});
  EXPECT_THROW(pinhole_from_fov(10, 10, 0.0, pose), Error);
  EXPECT_THROW(pinhole_from_fov(10, 10, 180.0, pose), Error);
  EXPECT_THROW(pinhole_from_fov(10, 10, NAN, pose), Error);
  EXPECT_THROW(pinhole_from_fov(0, 10, 50.0, pose), Error);
}

TEST(Camera, resizing_keeps_the_vertical_field_of_view) {
  Camera camera = pinhole_from_fov(600, 400, 50.0, look_at({0, 0, 0}, {0, 1, 0}));
  camera.cy = 100.0;
  const Camera large = resized(camera, 2400, 800);
  EXPECT_EQ(large.width, 2400);
  for (const double y : {0.0, 100.0, 400.0}) {
    EXPECT_NEAR(glm::length(camera_ray(camera, {300.0, y}).direction -
                            camera_ray(large, {1200.0, 2.0 * y}).direction),
                0.0, 1e-14);
  }
}

TEST(Camera, a_resized_panorama_keeps_its_whole_sphere) {
  const Camera narrow = resized(panorama_camera({1, 2, 3}, 400, 200), 100, 300);
  // The middle of the image looks north, its sides south, a quarter of it east; the rows run from zenith to
  // nadir.
  const std::pair<glm::dvec2, glm::dvec3> expected[] = {
      {{50, 150}, {0, 1, 0}},   {{75, 150}, {1, 0, 0}}, {{25, 150}, {-1, 0, 0}}, {{0, 150}, {0, -1, 0}},
      {{100, 150}, {0, -1, 0}}, {{50, 0}, {0, 0, 1}},   {{50, 300}, {0, 0, -1}}};
  for (const auto& [film, direction] : expected)
    EXPECT_LT(glm::length(camera_ray(narrow, film).direction - direction), 1e-12) << film.x << " " << film.y;
}

TEST(Camera, the_ground_of_a_turned_image_is_where_its_pixels_look) {
  // Its upper side is where (-0.8, 0.6) points, 4 pixels a metre across and 2 down.
  const Camera turned{.width = 20,
                      .height = 10,
                      .fx = 4.0,
                      .fy = 2.0,
                      .cx = 8.0,
                      .cy = 6.0,
                      .pose = {.position = {100, 200, 50},
                               .right = {0.6, 0.8, 0},
                               .down = {0.8, -0.6, 0},
                               .forward = {0, 0, -1}},
                      .lens = OrthographicLens{}};
  const std::array<double, 6> transform = ground_transform(turned);
  // GDAL: x = [0] + [1] column + [2] row, y = [3] + [4] column + [5] row. The axis is 2 m and 3 m from the
  // corner.
  const std::array<double, 6> expected = {100 - 2 * 0.6 - 3 * 0.8, 0.15, 0.4,
                                          200 - 2 * 0.8 + 3 * 0.6, 0.2,  -0.3};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(transform[i], expected[i], 1e-12) << i;
}

/// Largest distance of the box's corners from the image's centre, in half image sizes: 1 touches the edge.
double reach(const Camera& camera, const Bounds& bounds) {
  double result = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const auto film = project_to_film(
        camera, {(corner & 1) ? bounds.max.x : bounds.min.x, (corner & 2) ? bounds.max.y : bounds.min.y,
                 (corner & 4) ? bounds.max.z : bounds.min.z});
    if (!film) return INFINITY;
    result = std::max({result, std::abs(film->x / camera.width * 2.0 - 1.0),
                       std::abs(film->y / camera.height * 2.0 - 1.0)});
  }
  return result;
}

TEST(Camera, overview_shows_the_whole_box_and_fills_the_image) {
  const glm::dvec3 utm(690000.0, 5325000.0, 500.0);
  const Bounds boxes[] = {{utm, utm + glm::dvec3(100, 80, 20)},            // a site
                          {utm, utm + glm::dvec3(100, 80, 0)},             // flat
                          {utm, utm + glm::dvec3(0, 0, 50)},               // a pole
                          {utm, utm + glm::dvec3(2000, 1, 1)},             // a corridor
                          {{-122.5, 44.0, 100.0}, {-122.4, 44.1, 100.2}},  // degrees
                          {glm::dvec3(-1e-3), glm::dvec3(1e-3)}};
  for (const Bounds& box : boxes) {
    for (const auto& [width, height] : {std::pair(600, 400), std::pair(400, 600), std::pair(1, 1)}) {
      const Camera camera = overview_camera(box, width, height);
      EXPECT_LE(reach(camera, box), 0.97);
      EXPECT_GE(reach(camera, box), 0.9);
      EXPECT_GT(camera.pose.position.z, box.max.z);
      EXPECT_GT(camera.pose.forward.x, 0.1);
      EXPECT_GT(camera.pose.forward.y, 0.1);
    }
  }
}

TEST(Camera, overview_leaves_equal_margins) {
  const Bounds box{{0, 0, 0}, {100, 70, 30}};
  for (const auto& [width, height] : {std::pair(600, 400), std::pair(400, 600)}) {
    const Camera camera = overview_camera(box, width, height);
    Bounds film;
    for (int corner = 0; corner < 8; ++corner) {
      const auto position = project_to_film(
          camera, {(corner & 1) ? 100.0 : 0.0, (corner & 2) ? 70.0 : 0.0, (corner & 4) ? 30.0 : 0.0});
      ASSERT_TRUE(position);
      film.grow(glm::dvec3(*position, 0.0));
    }
    EXPECT_NEAR(film.min.x, width - film.max.x, 1.0);
    EXPECT_NEAR(film.min.y, height - film.max.y, 1.0);
  }
}

TEST(Camera, overview_of_a_single_position_and_of_nothing_is_a_usable_camera) {
  const glm::dvec3 position(690000.0, 5325000.0, 500.0);
  for (const Bounds& box : {Bounds{position, position}, Bounds{}, Bounds{glm::dvec3(3e9), glm::dvec3(3e9)}}) {
    const Camera camera = overview_camera(box, 600, 400);
    const auto film = project_to_film(camera, box.empty() ? glm::dvec3(0.0) : box.min);
    ASSERT_TRUE(film);
    EXPECT_NEAR(film->x, 300.0, 1.0);
    EXPECT_NEAR(film->y, 200.0, 40.0);
  }
}

TEST(Camera, overview_looks_to_an_azimuth) {
  const std::vector<glm::dvec3> positions = {{0, 0, 0}, {10, 0, 0}, {10, 8, 0}, {0, 8, 3}};
  const Camera to_south = overview_camera(positions, 0.1, 600, 400, 180.0);
  EXPECT_NEAR(to_south.pose.forward.x, 0.0, 1e-12);
  EXPECT_LT(to_south.pose.forward.y, -0.8);
  EXPECT_GT(to_south.pose.position.y, 8.0);
  EXPECT_EQ(overview_camera(positions, 0.1, 600, 400, 45.0).pose.position,
            overview_camera(positions, 0.1, 600, 400).pose.position);
}

TEST(Camera, a_filled_camera_keeps_its_pose_and_shows_all_positions_up_to_the_margin) {
  const CameraPose pose{.position = {1, 2, 3}, .right = {1, 0, 0}, .down = {0, 1, 0}, .forward = {0, 0, 1}};
  const std::vector<glm::dvec3> positions = {{0, 2, 5}, {4, 2, 5}, {1, 1, 7}, {1, 2.5, 4}};
  for (const auto& [width, height] : {std::pair(600, 400), std::pair(100, 400), std::pair(600, 100)}) {
    const std::optional<Camera> camera = filled_camera(pose, positions, width, height);
    ASSERT_TRUE(camera);
    EXPECT_EQ(camera->pose.position, pose.position);
    EXPECT_EQ(camera->fx, camera->fy);
    Bounds film;
    for (const glm::dvec3& position : positions)
      film.grow(glm::dvec3(project_to_film(*camera, position).value(), 0.0));
    EXPECT_NEAR(film.min.x + film.max.x, width, 1e-9);
    EXPECT_NEAR(film.min.y + film.max.y, height, 1e-9);
    EXPECT_NEAR(std::max(film.size().x / width, film.size().y / height), 0.96, 1e-9);
  }
}

TEST(Camera, no_camera_is_filled_by_positions_beside_it_or_by_one_alone) {
  const CameraPose pose{.right = {1, 0, 0}, .down = {0, 1, 0}, .forward = {0, 0, 1}};
  const auto is_filled = [&](const std::vector<glm::dvec3>& positions) {
    return filled_camera(pose, positions, 600, 400).has_value();
  };
  EXPECT_TRUE(is_filled({{0, 0, 1}, {3, 0, 1}}));
  EXPECT_FALSE(is_filled({{0, 0, 1}, {4, 0, 1}})) << "76 degrees";
  EXPECT_FALSE(is_filled({{0, 0, 1}, {1, 0, -1}}));
  EXPECT_FALSE(is_filled({{0, 0, 1}, {0, 0, 0}}));
  EXPECT_FALSE(is_filled({{0, 0, 1}, {0, 0, 2}}));
  EXPECT_FALSE(is_filled({}));
}

}  // namespace
}  // namespace alidade
