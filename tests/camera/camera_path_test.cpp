// SPDX-License-Identifier: MIT
#include "camera/camera_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "base/bounds.h"
#include "base/error.h"

namespace alidade::camera {
namespace {

Camera camera_at(const glm::dvec3& eye, const glm::dvec3& target) {
  return pinhole_from_fov(120, 80, 50.0, look_at(eye, target));
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-9) {
  EXPECT_LE(glm::length(a - b), tolerance) << a.x << ' ' << a.y << ' ' << a.z;
}

TEST(OrbitTest, cameras_stand_on_a_circle_and_see_the_box) {
  const Bounds box{{100, 200, 5}, {140, 220, 15}};
  std::vector<glm::dvec3> corners;
  for (int corner = 0; corner < 8; ++corner)
    corners.emplace_back(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                         corner & 4 ? box.max.z : box.min.z);
  const std::vector<Camera> cameras = orbit_cameras(corners, 120, 80, 12);
  ASSERT_EQ(cameras.size(), 12u);
  const glm::dvec3 first = cameras[0].pose.position - box.center();
  // From the south-west, then to the south-east.
  EXPECT_LT(first.x, 0.0);
  EXPECT_LT(first.y, 0.0);
  EXPECT_GT(cameras[3].pose.position.x, box.center().x);
  EXPECT_LT(cameras[3].pose.position.y, box.center().y);
  for (const Camera& camera : cameras) {
    const glm::dvec3 from = camera.pose.position - box.center();
    EXPECT_NEAR(std::hypot(from.x, from.y), std::hypot(first.x, first.y), 1e-9);
    EXPECT_NEAR(from.z, first.z, 1e-9);
    for (const glm::dvec3& position : corners) {
      const auto pixel = project_to_film(camera, position);
      ASSERT_TRUE(pixel);
      EXPECT_GE(pixel->x, 0.0);
      EXPECT_LE(pixel->x, 120.0);
      EXPECT_GE(pixel->y, 0.0);
      EXPECT_LE(pixel->y, 80.0);
    }
  }
}

TEST(KeyframesTest, the_way_begins_and_ends_at_keyframes_and_passes_the_others) {
  const std::vector<Camera> keyframes = {camera_at({0, 0, 2}, {10, 0, 2}), camera_at({10, 0, 2}, {10, 10, 0}),
                                         camera_at({10, 10, 4}, {0, 10, 2})};
  const std::vector<Camera> cameras = cameras_between(keyframes, 2001);
  ASSERT_EQ(cameras.size(), 2001u);
  expect_near(cameras.front().pose.position, keyframes.front().pose.position);
  expect_near(cameras.front().pose.forward, keyframes.front().pose.forward);
  expect_near(cameras.back().pose.position, keyframes.back().pose.position);
  expect_near(cameras.back().pose.forward, keyframes.back().pose.forward);
  double nearest = 1e9;
  for (const Camera& camera : cameras)
    nearest = std::min(nearest, glm::length(camera.pose.position - keyframes[1].pose.position));
  EXPECT_LT(nearest, 0.02);
}

TEST(KeyframesTest, speed_is_constant_and_nothing_jumps) {
  const std::vector<Camera> keyframes = {camera_at({0, 0, 2}, {10, 0, 2}), camera_at({1, 0, 2}, {11, 0, 2}),
                                         camera_at({20, 0, 2}, {30, 0, 2})};
  const std::vector<Camera> cameras = cameras_between(keyframes, 101);
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    EXPECT_NEAR(glm::length(cameras[i].pose.position - cameras[i - 1].pose.position), 0.2, 0.004) << i;
    EXPECT_NEAR(glm::length(cameras[i].pose.forward), 1.0, 1e-12);
    EXPECT_NEAR(glm::dot(cameras[i].pose.forward, cameras[i].pose.down), 0.0, 1e-12);
  }
}

TEST(KeyframesTest, a_camera_that_stays_turns) {
  const std::vector<Camera> keyframes = {camera_at({0, 0, 2}, {10, 0, 2}), camera_at({0, 0, 2}, {0, 10, 2})};
  const std::vector<Camera> cameras = cameras_between(keyframes, 5);
  expect_near(cameras[2].pose.position, {0, 0, 2});
  expect_near(cameras[2].pose.forward, {std::sqrt(0.5), std::sqrt(0.5), 0.0}, 1e-6);
}

TEST(KeyframesTest, other_sizes_are_an_error) {
  std::vector<Camera> keyframes = {camera_at({0, 0, 2}, {10, 0, 2}), camera_at({1, 0, 2}, {11, 0, 2})};
  keyframes[1].width = 60;
  EXPECT_THROW(cameras_between(keyframes, 5), Error);
}

}  // namespace
}  // namespace alidade::camera
