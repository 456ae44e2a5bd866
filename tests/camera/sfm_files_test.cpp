// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "camera/projection.h"
#include "tests/camera/camera_file_text.h"

namespace alidade::test {

using namespace camera;

namespace {

std::string opensfm(const std::string& camera) {
  return R"([{"cameras": {"one": )" + camera + R"(}, "shots": {
    "b.jpg": {"camera": "one", "rotation": [0, 0, 1.5707963267948966], "translation": [1, 2, 3]},
    "a.jpg": {"camera": "one", "rotation": [0, 0, 0], "translation": [0, 0, 0]}},
    "points": {"1": {"coordinates": [1, 2, 3], "color": [1, 2, 3]}}}])";
}

TEST(OpenSfm, poses_are_axis_and_angle_from_world_to_camera) {
  const CameraSet set = parse(opensfm(R"({"width": 640, "height": 480, "focal": 0.8, "k1": 0, "k2": 0})"));
  ASSERT_EQ(set.cameras.size(), 2u);
  expect_pose(set.cameras[0].camera.pose, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  // A quarter turn about z brings x to y: camera = (-y + 1, x + 2, z + 3).
  expect_pose(set.cameras[1].camera.pose, {{-2, 1, -3}, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}});
}

// The documented formula of each kind of camera, in pixels, by hand.
TEST(OpenSfm, every_kind_of_camera_is_its_formula) {
  const double u = 0.2, v = -0.1, r2 = u * u + v * v, r = std::sqrt(r2), theta = std::atan(r);
  const double a = u * theta / r, b = v * theta / r, q = theta * theta;
  const auto expect = [&](const std::string& type, const std::string& keys, double fx, double fy, double cx,
                          double cy, double ud, double vd) {
    const CameraSet set = parse(
        opensfm(fmt::format(R"({{"projection_type": "{}", "width": 640, "height": 480, {}}})", type, keys)));
    const glm::dvec2 film = Projection(set.cameras[0].camera).project({u, v, 1.0}).value();
    EXPECT_NEAR(film.x, (fx * ud + cx) * 640 + 320, 1e-10) << type;
    EXPECT_NEAR(film.y, (fy * vd + cy) * 640 + 240, 1e-10) << type;
  };
  const std::string one = R"("focal": 0.8)",
                    two = R"("focal_x": 0.8, "focal_y": 0.9, "c_x": 0.01, "c_y": -0.02)";
  const double radial = 1 + 0.1 * r2 + 0.2 * r2 * r2, fish = 1 + 0.1 * q + 0.2 * q * q;
  expect("perspective", one + R"(, "k1": 0.1, "k2": 0.2)", 0.8, 0.8, 0, 0, u * radial, v * radial);
  expect("radial", two + R"(, "k1": 0.1, "k2": 0.2)", 0.8, 0.9, 0.01, -0.02, u * radial, v * radial);
  expect("simple_radial", two + R"(, "k1": 0.1)", 0.8, 0.9, 0.01, -0.02, u * (1 + 0.1 * r2),
         v * (1 + 0.1 * r2));
  const double p1 = 0.01, p2 = 0.02, brown = radial + 0.3 * r2 * r2 * r2;
  expect("brown", two + R"(, "k1": 0.1, "k2": 0.2, "k3": 0.3, "p1": 0.01, "p2": 0.02)", 0.8, 0.9, 0.01, -0.02,
         u * brown + 2 * p1 * u * v + p2 * (r2 + 2 * u * u),
         v * brown + 2 * p2 * u * v + p1 * (r2 + 2 * v * v));
  expect("fisheye", one + R"(, "k1": 0.1, "k2": 0.2)", 0.8, 0.8, 0, 0, a * fish, b * fish);
  const double fish4 = fish + 0.3 * q * q * q + 0.4 * q * q * q * q;
  expect("fisheye_opencv", two + R"(, "k1": 0.1, "k2": 0.2, "k3": 0.3, "k4": 0.4)", 0.8, 0.9, 0.01, -0.02,
         a * fish4, b * fish4);
  const double fish6 = fish4 + 0.5 * std::pow(q, 5) + 0.6 * std::pow(q, 6);
  const double bend_a = 2 * p1 * a * b + p2 * (q + 2 * a * a), bend_b = 2 * p2 * a * b + p1 * (q + 2 * b * b);
  const std::string six =
      two + R"(, "k1": 0.1, "k2": 0.2, "k3": 0.3, "k4": 0.4, "k5": 0.5, "k6": 0.6, "p1": 0.01, "p2": 0.02)";
  expect("fisheye62", six, 0.8, 0.9, 0.01, -0.02, a * fish6 + bend_a, b * fish6 + bend_b);
  expect("fisheye624", six + R"(, "s0": 0.1, "s1": 0.2, "s2": 0.3, "s3": 0.4)", 0.8, 0.9, 0.01, -0.02,
         a * fish6 + bend_a + 0.1 * q + 0.2 * q * q, b * fish6 + bend_b + 0.3 * q + 0.4 * q * q);
  const double l = 0.3, mu = l * u + (1 - l) * a, mv = l * v + (1 - l) * b, m = mu * mu + mv * mv;
  expect("dual", one + R"(, "k1": 0.1, "k2": 0.2, "transition": 0.3)", 0.8, 0.8, 0, 0,
         mu * (1 + 0.1 * m + 0.2 * m * m), mv * (1 + 0.1 * m + 0.2 * m * m));
  for (const char* const type : {"spherical", "equirectangular"}) {
    expect(type, R"("s": 0)", 1, 1, 0, 0, std::atan2(u, 1.0) / (2 * std::numbers::pi),
           -std::atan2(-v, std::hypot(u, 1.0)) / (2 * std::numbers::pi));
  }
}

TEST(OpenSfm, further_reconstructions_are_left_out_with_a_warning) {
  const std::string one = opensfm(R"({"width": 640, "height": 480, "focal": 0.8})");
  const CameraSet set = parse(fmt::format("[{},{}", one.substr(1, one.size() - 2), one.substr(1)));
  EXPECT_EQ(set.cameras.size(), 2u);
  EXPECT_NE(set.warnings.at(0).find("only the first of 2 reconstructions"), std::string::npos);
}

TEST(OpenSfm, damage_is_an_error_at_its_location) {
  expect_error(opensfm(R"({"width": 640, "height": 480, "focal": 0})"),
               "number out of range (at /0/cameras/one/focal)");
  expect_error(opensfm(R"({"width": 640, "height": 480})"), "missing key \"focal_x\"");
  expect_error(opensfm(R"({"width": 640, "focal": 0.8})"), "missing key \"height\"");
  expect_error(opensfm(R"({"projection_type": "pinhole", "width": 640, "height": 480, "focal": 0.8})"),
               "unknown value");
  const std::string good = opensfm(R"({"width": 640, "height": 480, "focal": 0.8})");
  expect_error(replaced(good, "\"camera\": \"one\"", "\"camera\": \"two\""),
               "unknown camera (at /0/shots/b.jpg/camera)");
  expect_error(replaced(good, "[0, 0, 1.5707963267948966]", "[0, 0, 1e300]"), "number out of range");
  expect_error(replaced(good, "[1, 2, 3]}", "[1, 2]}"), "wrong number of values");
  expect_error("[{\"cameras\": {}, \"shots\": {}}]", "contains no camera with a pose");
}

const std::string k_openmvg = R"({"sfm_data_version": "0.3", "root_path": "/foreign",
  "views": [
    {"key": 0, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483649, "data": {"local_path": "", "filename": "b.jpg",
      "width": 640, "height": 480, "id_view": 0, "id_intrinsic": 0, "id_pose": 0}}}},
    {"key": 1, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483650, "data": {"local_path": "sub", "filename": "a.jpg",
      "width": 640, "height": 480, "id_view": 1, "id_intrinsic": 1, "id_pose": 1}}}},
    {"key": 2, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483651, "data": {"local_path": "", "filename": "c.jpg",
      "width": 640, "height": 480, "id_view": 2, "id_intrinsic": 0, "id_pose": 4294967295}}}}],
  "intrinsics": [
    {"key": 0, "value": {"polymorphic_id": 2147483649, "polymorphic_name": "pinhole_radial_k3", "ptr_wrapper": {"id": 2147483652,
      "data": {"width": 640, "height": 480, "focal_length": 500, "principal_point": [321, 243], "disto_k3": [0.1, 0.02, 0.003]}}}},
    {"key": 1, "value": {"polymorphic_id": 1, "ptr_wrapper": {"id": 2147483653,
      "data": {"value0": {"width": 640, "height": 480, "focal_length": 600, "principal_point": [320, 240]}, "disto_k3": [0, 0, 0]}}}}],
  "extrinsics": [
    {"key": 0, "value": {"rotation": [[0, -1, 0], [0, 0, -1], [1, 0, 0]], "center": [1, 2, 3]}},
    {"key": 1, "value": {"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "center": [0, 0, 0]}}],
  "structure": [{"key": 0, "value": {"X": [1, 2, 3], "observations": []}}], "control_points": []})";

TEST(OpenMvg, poses_have_a_center_and_pixels_get_half_a_pixel) {
  const CameraSet set = parse(k_openmvg);
  ASSERT_EQ(set.cameras.size(), 2u);
  EXPECT_EQ(set.cameras[0].name, "b.jpg");
  EXPECT_EQ(set.cameras[1].name, "sub/a.jpg");
  const Camera& camera = set.cameras[0].camera;
  expect_pose(camera.pose, {{1, 2, 3}, {0, -1, 0}, {0, 0, -1}, {1, 0, 0}});
  EXPECT_EQ(camera.fx, 500.0);
  EXPECT_EQ(camera.cx, 321.5);
  EXPECT_EQ(camera.cy, 243.5);
  EXPECT_EQ(std::get<BrownLens>(camera.lens).distortion.radial, (std::array<double, 6>{0.1, 0.02, 0.003}));
  // The second intrinsic names its type by number and keeps its base apart.
  EXPECT_EQ(set.cameras[1].camera.fx, 600.0);
  EXPECT_NE(set.warnings.at(0).find("1 views without a pose"), std::string::npos);
}

TEST(OpenMvg, every_kind_of_camera_is_read) {
  const auto lens = [](const std::string& type, const std::string& keys) {
    return parse(replaced(replaced(k_openmvg, "\"pinhole_radial_k3\"", "\"" + type + "\""),
                          "\"disto_k3\": [0.1, 0.02, 0.003]",
                          keys + ", \"disto_k3\": [0, 0, 0], \"disto_k1\": [0]"))
        .cameras[0]
        .camera;
  };
  // The other view has the same type.
  const auto both = [](const std::string& type, const std::string& keys) {
    std::string text = replaced(replaced(k_openmvg, "\"pinhole_radial_k3\"", "\"" + type + "\""),
                                "\"disto_k3\": [0.1, 0.02, 0.003]", keys);
    return parse(replaced(text, "\"disto_k3\": [0, 0, 0]", keys)).cameras[0].camera;
  };
  EXPECT_TRUE(std::holds_alternative<PinholeLens>(lens("pinhole", "\"x\": 0").lens));
  EXPECT_EQ(std::get<BrownLens>(both("pinhole_radial_k1", "\"disto_k1\": [0.1]").lens).distortion.radial[0],
            0.1);
  const Distortion brown =
      std::get<BrownLens>(both("pinhole_brown_t2", "\"disto_t2\": [0.1, 0.2, 0.3, 0.04, 0.05]").lens)
          .distortion;
  EXPECT_EQ(brown.radial, (std::array<double, 6>{0.1, 0.2, 0.3}));
  EXPECT_EQ(brown.p1, 0.04);
  EXPECT_EQ(brown.p2, 0.05);
  EXPECT_EQ(
      std::get<FisheyeLens>(both("fisheye", "\"fisheye\": [0.1, 0.2, 0.3, 0.4]").lens).distortion.radial,
      (std::array<double, 6>{0.1, 0.2, 0.3, 0.4}));
  const Camera sphere = both("spherical", "\"x\": 0");
  EXPECT_TRUE(std::holds_alternative<EquirectangularLens>(sphere.lens));
  EXPECT_NEAR(sphere.fy, 640.0 / (2.0 * std::numbers::pi), 1e-12);
  EXPECT_EQ(sphere.cx, 320.5);
}

TEST(OpenMvg, objects_written_once_are_found_again) {
  const CameraSet set = parse(replaced(k_openmvg,
                                       R"("ptr_wrapper": {"id": 2147483653,
      "data": {"value0": {"width": 640, "height": 480, "focal_length": 600, "principal_point": [320, 240]}, "disto_k3": [0, 0, 0]}})",
                                       R"("ptr_wrapper": {"id": 4})"));
  EXPECT_EQ(set.cameras[1].camera.fx, 500.0);
}

TEST(OpenMvg, damage_is_an_error_at_its_location) {
  expect_error(
      replaced(k_openmvg, "[[0, -1, 0], [0, 0, -1], [1, 0, 0]]", "[[0, -1, 0], [0, 0, -1], [0, 0, 0]]"),
      "invalid rotation (at /extrinsics/0/value/rotation)");
  expect_error(replaced(k_openmvg, "\"focal_length\": 500", "\"focal_length\": 0"), "number out of range");
  expect_error(replaced(k_openmvg, "\"pinhole_radial_k3\"", "\"pinhole_9\""),
               "unsupported camera type (at /intrinsics/0/value)");
  expect_error(replaced(k_openmvg, "\"polymorphic_id\": 1,", "\"polymorphic_id\": 5,"), "unknown type");
  expect_error(replaced(k_openmvg, "\"id_intrinsic\": 1", "\"id_intrinsic\": 8"), "unknown intrinsic");
  expect_error(replaced(k_openmvg, "\"disto_k3\": [0.1, 0.02, 0.003]", "\"disto_k3\": [0.1]"),
               "wrong number of values");
  expect_error(R"({"sfm_data_version": "0.3"})", "contains no camera with a pose");
}

}  // namespace
}  // namespace alidade::test
