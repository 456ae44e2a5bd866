// SPDX-License-Identifier: MIT
#include "camera/camera_set.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "camera/projection.h"

namespace alidade {

using namespace camera;

namespace {

E57Image posed() {
  E57Image image;
  // A turn that takes x to y, y to z and z to x.
  image.pose =
      E57Pose{.rotation = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, .translation = {10, 20, 30}, .is_rotated = true};
  return image;
}

E57Picture pinhole() {
  E57Picture picture;
  picture.projection = E57Projection::pinhole;
  picture.width = 400;
  picture.height = 300;
  picture.focal_length = 0.02;
  picture.pixel_width = 1e-4;
  picture.pixel_height = 2e-4;
  picture.principal_x = 210.5;
  picture.principal_y = 140.25;
  return picture;
}

TEST(E57Camera, pinhole_looks_along_minus_z_with_y_up) {
  const E57Image image = posed();
  const std::optional<Camera> camera = camera_of(image, pinhole());
  ASSERT_TRUE(camera);
  check_camera(*camera);
  const Projection projection(*camera);
  for (const glm::dvec3 position :
       {glm::dvec3(0.3, 0.2, -2), glm::dvec3(-1, 0.5, -4), glm::dvec3(0, 0, -1)}) {
    const glm::dvec3 world = image.pose->rotation * position + image.pose->translation;
    const auto film = projection.project(world);
    ASSERT_TRUE(film);
    // u = cx - (x / z) f / w, v = cy + (y / z) f / h.
    EXPECT_NEAR(film->x, 210.5 - position.x / position.z * 0.02 / 1e-4, 1e-9);
    EXPECT_NEAR(film->y, 140.25 + position.y / position.z * 0.02 / 2e-4, 1e-9);
  }
}

TEST(E57Camera, spherical_looks_along_x_with_azimuth_growing_to_the_left) {
  const E57Image image = posed();
  E57Picture picture;
  picture.projection = E57Projection::spherical;
  picture.width = 360;
  picture.height = 180;
  picture.pixel_width = picture.pixel_height = std::numbers::pi / 180;
  const std::optional<Camera> camera = camera_of(image, picture);
  ASSERT_TRUE(camera);
  check_camera(*camera);
  const Projection projection(*camera);
  const auto film_of = [&](double azimuth, double elevation) {
    const double a = azimuth * std::numbers::pi / 180, e = elevation * std::numbers::pi / 180;
    const glm::dvec3 position(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
    return *projection.project(image.pose->rotation * (5.0 * position) + image.pose->translation);
  };
  EXPECT_NEAR(film_of(0, 0).x, 180, 1e-9);
  EXPECT_NEAR(film_of(0, 0).y, 90, 1e-9);
  EXPECT_NEAR(film_of(30, 0).x, 150, 1e-9);
  EXPECT_NEAR(film_of(-30, 40).x, 210, 1e-9);
  EXPECT_NEAR(film_of(-30, 40).y, 50, 1e-9);
}

TEST(E57Camera, of_other_pictures_and_impossible_numbers_is_empty) {
  E57Picture picture = pinhole();
  picture.pixel_width = 0;
  EXPECT_FALSE(camera_of({}, picture));
  picture = pinhole();
  picture.focal_length = -1;
  EXPECT_FALSE(camera_of({}, picture));
  picture = pinhole();
  picture.width = 0;
  EXPECT_FALSE(camera_of({}, picture));
  picture.width = std::uint64_t{1} << 40;
  EXPECT_FALSE(camera_of({}, picture));
  for (const E57Projection projection : {E57Projection::visual, E57Projection::cylindrical}) {
    picture = pinhole();
    picture.projection = projection;
    EXPECT_FALSE(camera_of({}, picture));
  }
}

TEST(E57Camera, without_a_pose_is_in_the_axes_of_the_file) {
  const std::optional<Camera> camera = camera_of({}, pinhole());
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->pose.position, glm::dvec3(0));
  EXPECT_EQ(camera->pose.forward, glm::dvec3(0, 0, -1));
}

}  // namespace
}  // namespace alidade
