// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/error.h"
#include "camera/camera.h"
#include "camera/camera_json.h"
#include "renderer/read_scene.h"
#include "tests/camera/lens_cases.h"
#include "tests/renderer/describe_scene.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

Camera camera_of(const std::string& intrinsics, const std::string& pose, int width = 600, int height = 400) {
  return parse_camera(fmt::format(R"({{"version": 1, "model": "pinhole", "width": {}, "height": {},
                                      "intrinsics": {{{}}}, "pose": {{{}}}}})",
                                  width, height, intrinsics, pose),
                      "camera.json");
}

CameraPose pose_of(const std::string& pose) {
  return camera_of(R"("vertical_fov": 50)", pose).pose;
}

std::string error_of(const std::string& intrinsics, const std::string& pose, int width = 600,
                     int height = 400) {
  try {
    camera_of(intrinsics, pose, width, height);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string pose_error(const std::string& pose) {
  return error_of(R"("vertical_fov": 50)", pose);
}

void expect_same(const CameraPose& a, const CameraPose& b, double tolerance) {
  EXPECT_LE(glm::length(a.position - b.position), tolerance);
  EXPECT_LE(glm::length(a.right - b.right), tolerance);
  EXPECT_LE(glm::length(a.down - b.down), tolerance);
  EXPECT_LE(glm::length(a.forward - b.forward), tolerance);
}

const std::string k_view = R"("look_at": {"eye": [0, 0, 0], "target": [0, 1, 0]})";

TEST(ReadCameraTest, look_at_is_the_camera_headers) {
  const CameraPose pose = pose_of(R"("look_at": {"eye": [1, 2, 3], "target": [4, 6, 2], "up": [0, 1, 1]})");
  expect_same(pose, look_at({1, 2, 3}, {4, 6, 2}, {0, 1, 1}), 0.0);
}

TEST(ReadCameraTest, fields_of_view_give_square_pixels_and_a_central_principal_point) {
  const Camera vertical = camera_of(R"("vertical_fov": 90)", k_view);
  EXPECT_NEAR(vertical.fx, 200.0, 1e-9);
  EXPECT_NEAR(vertical.fy, 200.0, 1e-9);
  const Camera horizontal = camera_of(R"("horizontal_fov": 90)", k_view);
  EXPECT_NEAR(horizontal.fx, 300.0, 1e-9);
  EXPECT_NEAR(horizontal.fy, 300.0, 1e-9);
  for (const Camera& camera : {vertical, horizontal}) {
    EXPECT_EQ(camera.width, 600);
    EXPECT_EQ(camera.height, 400);
    EXPECT_EQ(camera.cx, 300.0);
    EXPECT_EQ(camera.cy, 200.0);
  }
}

TEST(ReadCameraTest, intrinsics_in_pixels_are_taken_as_they_are) {
  const Camera camera = camera_of(R"("fx": 512.25, "fy": 500, "cx": -3.5, "cy": 1000)", k_view);
  EXPECT_EQ(camera.fx, 512.25);
  EXPECT_EQ(camera.fy, 500.0);
  EXPECT_EQ(camera.cx, -3.5);
  EXPECT_EQ(camera.cy, 1000.0);
}

// The identity in both conventions, by hand.
TEST(ReadCameraTest, conventions_say_where_the_axes_point) {
  const std::string matrix =
      R"("matrix": [[1,0,0,7],[0,1,0,8],[0,0,1,9],[0,0,0,1]], "direction": "camera_to_world",)";
  expect_same(pose_of(matrix + R"("convention": "opencv")"), {{7, 8, 9}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
              0.0);
  expect_same(pose_of(matrix + R"("convention": "opengl")"), {{7, 8, 9}, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
              0.0);
}

// A camera at (1, 2, 3) that looks east, upright: right is south, down is down. Rows of world_to_camera are
// these axes.
TEST(ReadCameraTest, matrices_by_hand_in_all_four_readings) {
  const CameraPose expected{{1, 2, 3}, {0, -1, 0}, {0, 0, -1}, {1, 0, 0}};
  const auto matrix = [](const std::string& rows, const std::string& convention,
                         const std::string& direction) {
    return fmt::format(R"("matrix": [{}, [0,0,0,1]], "convention": "{}", "direction": "{}")", rows,
                       convention, direction);
  };
  expect_same(pose_of(matrix("[0,0,1,1],[-1,0,0,2],[0,-1,0,3]", "opencv", "camera_to_world")), expected, 0.0);
  expect_same(pose_of(matrix("[0,0,-1,1],[-1,0,0,2],[0,1,0,3]", "opengl", "camera_to_world")), expected, 0.0);
  expect_same(pose_of(matrix("[0,-1,0,2],[0,0,-1,3],[1,0,0,-1]", "opencv", "world_to_camera")), expected,
              0.0);
  expect_same(pose_of(matrix("[0,-1,0,2],[0,0,1,-3],[-1,0,0,1]", "opengl", "world_to_camera")), expected,
              0.0);
}

TEST(ReadCameraTest, quaternion_and_matrix_of_the_same_rotation_agree) {
  Random random;
  for (int round = 0; round < 200; ++round) {
    const glm::dvec3 axis = glm::normalize(random.direction());
    const double angle = random.between(0.0, 2.0 * std::numbers::pi);
    // Rodrigues' formula, column by column: an independent way to the matrix.
    glm::dvec3 columns[3];
    for (int i = 0; i < 3; ++i) {
      glm::dvec3 unit{0.0};
      unit[i] = 1.0;
      columns[i] = unit * std::cos(angle) + glm::cross(axis, unit) * std::sin(angle) +
                   axis * glm::dot(axis, unit) * (1.0 - std::cos(angle));
    }
    const glm::dvec3 t = 100.0 * random.in_cube();
    std::string rows;
    for (int i = 0; i < 3; ++i) {
      rows += fmt::format("[{:.17g},{:.17g},{:.17g},{:.17g}],", columns[0][i], columns[1][i], columns[2][i],
                          t[i]);
    }
    const double w = std::cos(angle / 2), s = std::sin(angle / 2);
    for (const std::string keys : {R"("convention": "opencv", "direction": "camera_to_world")",
                                   R"("convention": "opengl", "direction": "world_to_camera")"}) {
      const std::string quaternion = fmt::format(
          R"("quaternion": [{:.17g},{:.17g},{:.17g},{:.17g}], "translation": [{:.17g},{:.17g},{:.17g}], {})",
          w, s * axis.x, s * axis.y, s * axis.z, t.x, t.y, t.z, keys);
      expect_same(pose_of("\"matrix\": [" + rows + "[0,0,0,1]], " + keys), pose_of(quaternion), 1e-11);
    }
  }
}

TEST(ReadCameraTest, few_digits_are_made_orthonormal) {
  const CameraPose pose =
      pose_of(R"("matrix": [[0.7071068,-0.7071068,0,0],[0.7071068,0.7071068,0,0],[0,0,1,0],[0,0,0,1]],
    "convention": "opencv", "direction": "camera_to_world")");
  EXPECT_NEAR(glm::length(pose.right), 1.0, 1e-15);
  EXPECT_NEAR(glm::length(pose.down), 1.0, 1e-15);
  EXPECT_NEAR(glm::dot(pose.right, pose.down), 0.0, 1e-15);
  EXPECT_NEAR(pose.right.x, std::sqrt(0.5), 1e-7);
}

TEST(ReadCameraTest, convention_and_direction_are_never_guessed) {
  const std::string identity = R"("matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]])";
  const std::string turn = R"("quaternion": [1,0,0,0], "translation": [0,0,0])";
  for (const std::string& pose : {identity, turn}) {
    EXPECT_NE(pose_error(pose + R"(, "direction": "camera_to_world")").find("missing key \"convention\""),
              std::string::npos);
    EXPECT_NE(pose_error(pose + R"(, "convention": "opencv")").find("missing key \"direction\""),
              std::string::npos);
  }
}

TEST(ReadCameraTest, invalid_rotations_are_errors) {
  const std::string keys = R"(, "convention": "opencv", "direction": "camera_to_world")";
  const auto matrix = [&](const std::string& rows) {
    return pose_error("\"matrix\": [" + rows + "]" + keys);
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(matrix("[1,0,0,0],[0,1,0,0],[0,0,1.00001,0],[0,0,0,1]"),
                  "the rotation is not orthonormal (at /pose/matrix)"));
  EXPECT_TRUE(
      has(matrix("[1,0.00001,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]"), "the rotation is not orthonormal"));
  EXPECT_EQ(matrix("[1,0,0,0],[0,1,0,0],[0,0,1.0000001,0],[0,0,0,1]"), "no error");
  EXPECT_TRUE(has(matrix("[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]"), "the rotation is a reflection"));
  EXPECT_TRUE(has(matrix("[1,0,0,0],[0,1,0,0],[0,0,1,0],[4,5,6,1]"),
                  "the transform is not rigid (at /pose/matrix/3)"));
  EXPECT_TRUE(has(matrix("[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]"), "the rotation is not orthonormal"));
  EXPECT_TRUE(has(pose_error(R"("quaternion": [1,1,0,0], "translation": [0,0,0])" + keys),
                  "the quaternion is not normalized"));
  EXPECT_TRUE(has(pose_error(k_view + keys), "unknown key"));
  EXPECT_TRUE(has(pose_error(k_view + R"(, "matrix": [])"), "ambiguous pose"));
  EXPECT_TRUE(has(pose_error(""), "ambiguous pose"));
}

TEST(ReadCameraTest, impossible_views_are_errors_at_their_location) {
  const std::string same = pose_error(R"("look_at": {"eye": [1, 1, 1], "target": [1, 1, 1]})");
  EXPECT_NE(same.find("(at /pose/look_at)"), std::string::npos) << same;
  EXPECT_NE(pose_error(R"("look_at": {"eye": [1, 1, 1], "target": [1, 1, 9]})").find("parallel"),
            std::string::npos);
}

TEST(ReadCameraTest, ambiguous_or_partial_intrinsics_are_errors) {
  EXPECT_NE(error_of(R"("vertical_fov": 50, "horizontal_fov": 60)", k_view).find("unknown key"),
            std::string::npos);
  EXPECT_NE(error_of(R"("fx": 500, "fy": 500, "cx": 300)", k_view).find("missing key \"cy\""),
            std::string::npos);
  EXPECT_NE(error_of("", k_view).find("missing focal length"), std::string::npos);
  EXPECT_NE(error_of(R"("vertical_fov": 180)", k_view).find("number out of range"), std::string::npos);
}

TEST(ReadCameraTest, images_have_at_most_2_to_the_28_pixels) {
  EXPECT_EQ(error_of(R"("vertical_fov": 50)", k_view, 16384, 16384), "no error");
  EXPECT_NE(error_of(R"("vertical_fov": 50)", k_view, 16384, 16385).find("image too large"),
            std::string::npos);
}

TEST(ReadCameraTest, what_metadata_keep_gives_back_the_same_bits) {
  Random random;
  for (const auto& [name, each] : lens_cases()) {
    for (int round = 0; round < 20; ++round) {
      Camera camera = each;
      camera.fx += random.between(0, 20);
      camera.cx += random.between(0, 1);
      const glm::dvec3 forward = glm::normalize(random.direction());
      const glm::dvec3 right = glm::normalize(glm::cross(forward, random.direction()));
      camera.pose = {1e6 * random.in_cube(), right, glm::cross(forward, right), forward};
      EXPECT_EQ(describe(parse_camera(camera_json(camera), "metadata")), describe(camera)) << name;
    }
  }
}

Camera camera_with(const std::string& model, const std::string& intrinsics,
                   const std::string& distortion = "") {
  return parse_camera(fmt::format(R"({{"version": 1, "model": "{}", "width": 600, "height": 400,
                                      "intrinsics": {{{}}}, {} "pose": {{{}}}}})",
                                  model, intrinsics,
                                  distortion.empty() ? "" : "\"distortion\": {" + distortion + "},", k_view),
                      "camera.json");
}

std::string error_with(const std::string& model, const std::string& intrinsics,
                       const std::string& distortion = "") {
  try {
    camera_with(model, intrinsics, distortion);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(ReadCameraTest, parallel_rays_have_a_resolution_in_metres) {
  const Camera camera = camera_with("orthographic", R"("resolution": 0.25)");
  EXPECT_EQ(camera.fx, 4.0);
  EXPECT_EQ(camera.fy, 4.0);
  EXPECT_EQ(camera.cx, 300.0);
  EXPECT_EQ(camera.cy, 200.0);
}

TEST(ReadCameraTest, a_panorama_is_the_whole_sphere_unless_it_says_less) {
  const Camera whole = camera_with("equirectangular", "");
  EXPECT_NEAR(whole.fx, 600.0 / (2.0 * std::numbers::pi), 1e-12);
  EXPECT_NEAR(whole.fy, 400.0 / std::numbers::pi, 1e-12);
  const Camera part = camera_with("equirectangular", R"("horizontal_fov": 90, "vertical_fov": 60)");
  EXPECT_NEAR(part.fx, 600.0 / (0.5 * std::numbers::pi), 1e-12);
  EXPECT_NEAR(part.fy, 400.0 / (std::numbers::pi / 3.0), 1e-12);
}

TEST(ReadCameraTest, a_distorting_lens_may_have_a_field_of_view_as_focal_length) {
  const Camera camera = camera_with("brown", R"("vertical_fov": 90)", R"("k1": -0.1, "r8": 0.001)");
  EXPECT_NEAR(camera.fx, 200.0, 1e-9);
  const Distortion& distortion = std::get<BrownLens>(camera.lens).distortion;
  EXPECT_EQ(distortion.radial, (std::array<double, 6>{-0.1, 0.0, 0.0, 0.001, 0.0, 0.0}));
}

TEST(ReadCameraTest, distortion_that_folds_over_names_file_and_radius) {
  const std::string text = error_with("brown", R"("vertical_fov": 90)", R"("k1": -0.5)");
  EXPECT_NE(
      text.find("camera.json:1:1: the distortion folds over at 108.866 pixels from the principal point"),
      std::string::npos)
      << text;
}

TEST(ReadCameraTest, distortion_belongs_to_lenses_that_distort) {
  EXPECT_NE(error_with("pinhole", R"("vertical_fov": 90)", R"("k1": 0)").find("unknown key"),
            std::string::npos);
  EXPECT_NE(error_with("brown", R"("vertical_fov": 90)").find("missing key \"distortion\""),
            std::string::npos);
  EXPECT_NE(error_with("bron", R"("vertical_fov": 90)").find("did you mean \"brown\"?"), std::string::npos);
}

TEST(ReadCameraTest, a_camera_file_needs_its_version) {
  EXPECT_THROW(
      parse_camera(R"({"model": "pinhole", "width": 1, "height": 1, "intrinsics": {"vertical_fov": 50},
    "pose": {"look_at": {"eye": [0, 0, 0], "target": [0, 1, 0]}}})",
                   "camera.json"),
      Error);
}

}  // namespace
}  // namespace alidade::test
