// SPDX-License-Identifier: MIT
#include "visibility/photo_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "base/error.h"
#include "camera/camera.h"
#include "tests/visibility/wall_cloud.h"

namespace alidade::test {
namespace {

using namespace visibility;

/// 100 above the origin, straight down, 1000 pixels of focal length.
camera::Camera vertical_camera() {
  camera::Camera camera;
  camera.width = 800;
  camera.height = 600;
  camera.fx = camera.fy = 1000.0;
  camera.cx = 400.0;
  camera.cy = 300.0;
  camera.pose = {.position = {0, 0, 100}, .right = {1, 0, 0}, .down = {0, -1, 0}, .forward = {0, 0, -1}};
  return camera;
}

TEST(PhotoFrame, edges_of_the_image_are_inclusive) {
  const PhotoFrame frame(vertical_camera());
  ASSERT_TRUE(frame.film_position({40, 30, 0}));
  EXPECT_NEAR(frame.film_position({40, 30, 0})->x, 800.0, 1e-9);
  EXPECT_NEAR(frame.film_position({40, 30, 0})->y, 0.0, 1e-9);
  EXPECT_FALSE(frame.film_position({40.001, 0, 0}));
  EXPECT_FALSE(frame.film_position({0, -30.001, 0}));
  EXPECT_FALSE(frame.film_position({0, 0, 101})) << "behind the camera";
  EXPECT_FALSE(frame.film_position({0, 0, 100})) << "in it";
}

TEST(PhotoFrame, lens_distortion_moves_the_frame) {
  camera::Camera camera = vertical_camera();
  camera.lens = camera::BrownLens{.distortion = {.radial = {0.5}}};
  const PhotoFrame frame(camera);
  // x (1 + 0.5 x^2) = 0.4 at the edge.
  EXPECT_TRUE(frame.film_position({37.3, 0, 0}));
  EXPECT_FALSE(frame.film_position({37.4, 0, 0}));
}

TEST(PhotoFrame, what_a_distortion_folds_back_is_not_in_the_frame) {
  camera::Camera camera = vertical_camera();
  camera.lens = camera::BrownLens{.distortion = {.radial = {-1.0}}};
  camera.width = camera.height = 200;
  camera.cx = camera.cy = 100.0;
  const PhotoFrame frame(camera);
  // x (1 - x^2) is 0 again at x = 1, far beyond the fold at 0.577.
  EXPECT_TRUE(frame.film_position({0, 0, 0}));
  EXPECT_FALSE(frame.film_position({100, 0, 0}));
  EXPECT_FALSE(frame.film_position({99, 0, 0}));
}

TEST(PhotoFrame, the_cone_leaves_out_nothing_that_is_in_the_frame) {
  camera::Camera camera = vertical_camera();
  camera.cx = 700.0;  // off the middle, as of a cropped image
  camera.lens = camera::BrownLens{.distortion = {.radial = {-0.1, 0.02}, .p1 = 0.002, .p2 = -0.003}};
  const PhotoFrame frame(camera);
  const camera::Projection projection(camera);
  int inside = 0;
  for (int x = -100; x <= 100; ++x) {
    for (int y = -100; y <= 100; ++y) {
      const glm::dvec3 world(x, y, 0);
      const auto film = projection.project(world);
      const bool is_in = film && film->x >= 0 && film->x <= 800 && film->y >= 0 && film->y <= 600;
      ASSERT_EQ(frame.film_position(world).has_value(), is_in) << x << " " << y;
      inside += is_in;
    }
  }
  EXPECT_GT(inside, 4000);
}

TEST(PhotoFrame, ground_sampling_distance_of_level_ground_is_height_by_focal_length) {
  const PhotoFrame frame(vertical_camera());
  const PointSurface ground{.exists = true, .normal = {0, 0, 1}};
  for (const glm::dvec3& world : {glm::dvec3(0, 0, 0), glm::dvec3(40, 30, 0), glm::dvec3(-35, 10, 0)})
    EXPECT_NEAR(frame.ground_sampling_distance(world, ground), 0.1, 1e-6);
  EXPECT_NEAR(frame.ground_sampling_distance({0, 0, 50}, ground), 0.05, 1e-6);
}

TEST(PhotoFrame, slopes_and_points_without_a_surface) {
  const PhotoFrame frame(vertical_camera());
  const double root = std::sqrt(0.5);
  EXPECT_NEAR(frame.ground_sampling_distance({0, 0, 0}, {.exists = true, .normal = {root, 0, root}}),
              0.1 / std::sqrt(root), 1e-6);
  EXPECT_NEAR(frame.ground_sampling_distance({0, 0, 0}, {.exists = true, .normal = {1, 0, 0}}),
              0.1 / std::sqrt(k_least_view_sine), 1e-6)
      << "edge-on";
  // Off the axis a pixel covers cos^3 of its solid angle on the axis, at 1 / cos of the distance.
  const double cosine = 100.0 / std::hypot(40.0, 100.0);
  EXPECT_NEAR(frame.ground_sampling_distance({40, 0, 0}, {}), 0.1 * std::sqrt(cosine), 1e-6);
}

TEST(PhotoFrame, a_panorama_has_no_seam) {
  const PhotoFrame frame(camera::panorama_camera({0, 0, 0}, 3600, 1800));
  const double pixel = 2.0 * std::numbers::pi / 3600.0;
  for (const glm::dvec3& world : {glm::dvec3(0, 10, 0), glm::dvec3(0, -10, 0), glm::dvec3(10, 0, 0)})
    EXPECT_NEAR(frame.ground_sampling_distance(world, {}), 10.0 * pixel, 1e-6);
}

TEST(PhotoFrame, a_cloud_that_is_in_no_frame_is_an_error_that_guesses_why) {
  const auto photo_at = [](const glm::dvec3& eye, const glm::dvec3& target) {
    return std::vector<camera::NamedCamera>{
        {"a", camera::pinhole_from_fov(120, 90, 70.0, camera::look_at(eye, target))}};
  };
  const auto problem_in = [](const Octree& octree, const std::vector<camera::NamedCamera>& photos,
                             double reach = 1e9) -> std::string {
    try {
      check_photos(octree, photos, reach);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  // Ground of 20 by 20 with a wall right across it at x = 10, 3 high.
  const Occluders yard = WallCloud()
                             .add({0, 0, 0}, {20, 0, 0}, {0, 20, 0}, 0.25)
                             .add({10, 0, 0.25}, {0, 20, 0}, {0, 0, 2.75}, 0.25)
                             .occluders();
  const auto problem_with = [&](const glm::dvec3& eye, const glm::dvec3& target, double reach = 1e9) {
    return problem_in(yard.octree(), photo_at(eye, target), reach);
  };
  const auto expect = [](const std::string& problem, const std::string& part) {
    EXPECT_NE(problem.find(part), std::string::npos) << problem;
  };
  expect(problem_with({-2, 10, 1.5}, {-10, 10, 1}), "they look away from it; are their axes those of OpenGL");
  expect(problem_with({690000, 5325000, 600}, {690000, 5325010, 600}), "theirs is another one");
  expect(problem_with({2, 10, 1.5}, {10, 10, 1}, 0.5), "a larger --max-distance");
  expect(problem_with({-2, 10, 1.5}, {-10, 10, 1}), "cameras at x -2, y 10, z 1.5; a cloud at x 0 to 20");
  expect(problem_with({-10, 50, 1.5}, {-10, 50.5, 100}), "in its reference system and scale");
  EXPECT_EQ(problem_with({2, 10, 1.5}, {10, 10, 1}), "no error");

  const Octree far = build(make_cloud({{690000, 5325000, 600}, {690020, 5325020, 603}},
                                      {glm::dvec3(1e-3), glm::dvec3(690000, 5325000, 600)}));
  const auto problem_far = [&](const glm::dvec3& eye) {
    return problem_in(far, photo_at(eye, eye + glm::dvec3(1, 0, 0)));
  };
  expect(problem_far({5325000, 690010, 650}), "x and y of their positions are exchanged");
  // At (-300, 0, 2), towards the yard, but written as the inverse pose.
  std::vector<camera::NamedCamera> inverses = photo_at({-300, 10, 2}, {10, 10, 1});
  inverses[0].camera.pose = {
      .position = {10, 2, 300}, .right = {0, 0, 1}, .down = {-1, 0, 0}, .forward = {0, -1, 0}};
  expect(problem_in(yard.octree(), inverses), "are these from world to camera");
  EXPECT_NE(problem_in(far, {}).find("there is no photo"), std::string::npos);
  expect(problem_far({11.5, 48.1, 650}), "their positions are degrees, or local coordinates");
}

}  // namespace
}  // namespace alidade::test
