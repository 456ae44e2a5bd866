// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <OpenImageIO/imageio.h>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>

#include "octree/error.h"
#include "renderer/camera.h"
#include "renderer/camera/camera_json.h"
#include "renderer/camera/camera_set.h"
#include "renderer/camera/image_file_size.h"
#include "renderer/camera/projection.h"
#include "tests/renderer/describe_scene.h"
#include "tests/support/random.h"

namespace alidade::test {
namespace {

CameraSet parse(const std::string& text, const CameraFileOptions& options = {}) {
  return parse_cameras(text, "nowhere/cameras.json", options);
}

std::string error_of(const std::string& text, const CameraFileOptions& options = {}) {
  try {
    parse(text, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void expect_error(const std::string& text, const std::string& part) {
  const std::string error = error_of(text);
  EXPECT_NE(error.find(part), std::string::npos) << error << "\n  lacks " << part;
}

void expect_pose(const CameraPose& pose, const CameraPose& expected, double tolerance = 1e-14) {
  EXPECT_LT(glm::length(pose.position - expected.position), tolerance);
  EXPECT_LT(glm::length(pose.right - expected.right), tolerance);
  EXPECT_LT(glm::length(pose.down - expected.down), tolerance);
  EXPECT_LT(glm::length(pose.forward - expected.forward), tolerance);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  if (place == std::string::npos) throw std::logic_error("no " + from);
  return text.replace(place, from.size(), to);
}

// ---- our own ----

TEST(CameraFiles, our_own_file_is_a_set_of_one) {
  Camera camera = pinhole_from_fov(60, 40, 50.0, look_at({1, 2, 3}, {4, 5, 6}));
  camera.lens = BrownLens{{.radial = {-0.05}}};
  const CameraSet set = parse(camera_json(camera));
  ASSERT_EQ(set.cameras.size(), 1u);
  EXPECT_EQ(set.cameras[0].name, "cameras.json");
  EXPECT_EQ(describe(set.cameras[0].camera), describe(camera));
}

TEST(CameraFiles, other_json_is_an_error) {
  expect_error("{\"a\": 1}", "cameras.json:1:1: unknown kind of camera file");
  expect_error("[]", "wrong number of values");
  expect_error("{", "not valid JSON");
  expect_error("{\"frames\": 3}", "wrong type");
}

// ---- transforms.json ----

const std::string k_transforms = R"({"w": 640, "h": 480.0, "fl_x": 500, "fl_y": 510, "cx": 321, "cy": 243,
  "camera_model": "OPENCV", "k1": 0.1, "k2": 0.01, "p1": 0.001, "p2": -0.002, "applied_transform": [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]],
  "frames": [
    {"file_path": "images\\b.jpg", "transform_matrix": [[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9], [0, 0, 0, 1]]},
    {"file_path": "images/a.jpg", "transform_matrix": [[0, 0, -1, 1], [-1, 0, 0, 2], [0, 1, 0, 3]]}]})";

TEST(TransformsJson, columns_are_right_up_and_backward) {
  const CameraSet set = parse(k_transforms);
  ASSERT_EQ(set.cameras.size(), 2u);
  EXPECT_EQ(set.cameras[0].name, "images/a.jpg");
  EXPECT_EQ(set.cameras[1].name, "images/b.jpg");
  expect_pose(set.cameras[1].camera.pose, {{7, 8, 9}, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  // Looks east, upright: right is south.
  expect_pose(set.cameras[0].camera.pose, {{1, 2, 3}, {0, -1, 0}, {0, 0, -1}, {1, 0, 0}});
  const Camera& camera = set.cameras[0].camera;
  EXPECT_EQ(describe(Camera{camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, {}}),
            describe(Camera{640, 480, 500, 510, 321, 243, {}}));
  const Distortion& distortion = std::get<BrownLens>(camera.lens).distortion;
  EXPECT_EQ(distortion.radial, (std::array<double, 6>{0.1, 0.01}));
  EXPECT_EQ(distortion.p1, 0.001);
  EXPECT_EQ(distortion.p2, -0.002);
}

TEST(TransformsJson, the_world_before_the_conversion_comes_back) {
  // x_json = s (A x + a); the camera that saw x there must see it here at the same place of the film.
  const std::string text =
      replaced(replaced(k_transforms, "[[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0]]",
                        "[[0, 1, 0, 0.5], [1, 0, 0, -2], [0, 0, -1, 3]]"),
               "\"applied_transform\"", "\"applied_scale\": 0.25, \"applied_transform\"");
  const CameraSet changed = parse(text), original = parse(text, {.lens = {}, .original_world = true});
  EXPECT_EQ(changed.warnings.size(), 1u);
  EXPECT_EQ(original.warnings.size(), 0u);
  Random random;
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 x = 20.0 * random.in_cube();
    const glm::dvec3 there = 0.25 * (glm::dvec3(x.y, x.x, -x.z) + glm::dvec3(0.5, -2.0, 3.0));
    for (std::size_t each = 0; each < 2; ++each) {
      const auto expected = Projection(changed.cameras[each].camera).project(there);
      const auto found = Projection(original.cameras[each].camera).project(x);
      ASSERT_EQ(expected.has_value(), found.has_value());
      if (!expected) continue;
      EXPECT_LT(glm::length(*expected - *found), 1e-9 * (1.0 + glm::length(*expected)));
    }
  }
}

TEST(TransformsJson, focal_lengths_may_be_angles) {
  const auto fx = [](const std::string& keys) {
    return parse(replaced(k_transforms, "\"fl_x\": 500, \"fl_y\": 510", keys)).cameras[0].camera;
  };
  EXPECT_NEAR(fx(R"("camera_angle_x": 1.5707963267948966)").fx, 320.0, 1e-10);
  EXPECT_NEAR(fx(R"("camera_angle_x": 1.5707963267948966)").fy, 320.0, 1e-10);
  EXPECT_NEAR(fx(R"("fl_x": 7, "x_fov": 90)").fx, 320.0, 1e-10);
  EXPECT_NEAR(fx(R"("fl_x": 7, "camera_angle_y": 1.5707963267948966)").fy, 240.0, 1e-10);
  EXPECT_EQ(fx(R"("fl_x": 7, "camera_angle_x": 1)").fx, 7.0);
  expect_error(replaced(k_transforms, "\"fl_x\": 500, \"fl_y\": 510,", ""), "no focal length");
}

TEST(TransformsJson, lenses_are_told_by_model_and_flag) {
  const auto lens = [](const std::string& keys) {
    return parse(replaced(
        k_transforms, R"("camera_model": "OPENCV", "k1": 0.1, "k2": 0.01, "p1": 0.001, "p2": -0.002)", keys));
  };
  const std::string four = R"("k1": 0.1, "k2": 0.01, "k3": 0.001, "k4": 0.0001)";
  EXPECT_EQ(std::get<FisheyeLens>(lens(R"("camera_model": "OPENCV_FISHEYE", )" + four).cameras[0].camera.lens)
                .distortion.radial,
            (std::array<double, 6>{0.1, 0.01, 0.001, 0.0001}));
  EXPECT_EQ(
      std::get<FisheyeLens>(lens(R"("is_fisheye": true, )" + four).cameras[0].camera.lens).distortion.radial,
      (std::array<double, 6>{0.1, 0.01, 0.001, 0.0001}));
  EXPECT_EQ(std::get<BrownLens>(lens(R"("camera_model": "OPENCV", )" + four).cameras[0].camera.lens)
                .distortion.radial,
            (std::array<double, 6>{0.1, 0.01, 0.001, 0.0001}));
  // instant-ngp's reading, and it is said.
  const CameraSet ngp = lens(four);
  EXPECT_EQ(std::get<BrownLens>(ngp.cameras[0].camera.lens).distortion.radial,
            (std::array<double, 6>{0.1, 0.01}));
  EXPECT_NE(ngp.warnings.at(0).find("k3 and k4 are left out"), std::string::npos);
  EXPECT_EQ(std::get<BrownLens>(
                lens(R"("camera_model": "OPENCV", "distortion_params": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])")
                    .cameras[0]
                    .camera.lens)
                .distortion.p2,
            0.6);
  EXPECT_TRUE(std::holds_alternative<PinholeLens>(lens(R"("k1": 0)").cameras[0].camera.lens));
  const Camera sphere = lens(R"("camera_model": "EQUIRECTANGULAR")").cameras[0].camera;
  EXPECT_TRUE(std::holds_alternative<EquirectangularLens>(sphere.lens));
  EXPECT_NEAR(sphere.fx, 640.0 / (2.0 * std::numbers::pi), 1e-12);
  expect_error(replaced(k_transforms, "\"OPENCV\"", "\"FISHEYE624\""), "unknown word");
}

TEST(TransformsJson, a_frames_own_value_is_used_and_a_contradiction_is_said) {
  const CameraSet set = parse(replaced(k_transforms, "\"file_path\": \"images/a.jpg\"",
                                       "\"file_path\": \"images/a.jpg\", \"fl_x\": 600"));
  EXPECT_EQ(set.cameras[0].camera.fx, 600.0);
  EXPECT_EQ(set.cameras[1].camera.fx, 500.0);
  EXPECT_NE(set.warnings.at(0).find("\"fl_x\" stands at the top and in frames"), std::string::npos);
}

TEST(TransformsJson, a_scaled_pose_loses_its_scale_and_it_is_said) {
  const CameraSet set =
      parse(replaced(k_transforms, "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9], [0, 0, 0, 1]]",
                     "[[3, 0, 0, 7], [0, 3, 0, 8], [0, 0, 3, 9], [0, 0, 0, 1]]"));
  expect_pose(set.cameras[1].camera.pose, {{7, 8, 9}, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  EXPECT_NE(set.warnings.at(0).find("1 poses have a scale"), std::string::npos);
}

TEST(TransformsJson, damage_is_an_error_at_its_place) {
  expect_error(replaced(k_transforms, "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9]",
                        "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 1, 0, 9]"),
               "not a rotation (at /frames/0/transform_matrix)");
  expect_error(replaced(k_transforms, "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9]",
                        "[[0, 0, 0, 7], [0, 0, 0, 8], [0, 0, 0, 9]"),
               "not a rotation");
  expect_error(replaced(k_transforms, "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9]",
                        "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, -1, 9]"),
               "not a rotation");
  expect_error(replaced(k_transforms, "\"fl_x\": 500", "\"fl_x\": 0"), "number out of range (at /fl_x)");
  expect_error(replaced(k_transforms, "\"w\": 640", "\"w\": 0"), "number out of range (at /w)");
  expect_error(replaced(k_transforms, "\"file_path\": \"images/a.jpg\"", "\"file\": 1"),
               "missing key \"file_path\"");
  expect_error(replaced(k_transforms, "images/a.jpg", "images/b.jpg"), "camera 'images/b.jpg' stands twice");
  expect_error(R"({"frames": []})", "holds no camera with a pose");
  // Without a size the image must be there.
  expect_error(replaced(k_transforms, "\"w\": 640, ", ""),
               "size of the image is not told and its file is missing (at /frames/0)");
}

TEST(TransformsJson, a_size_that_is_not_told_is_the_images) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "alidade_transforms";
  std::filesystem::create_directories(folder);
  const auto image = OIIO::ImageOutput::create((folder / "r_0.png").string());
  const OIIO::ImageSpec spec(30, 20, 3, OIIO::TypeUInt8);
  ASSERT_TRUE(image->open((folder / "r_0.png").string(), spec));
  const std::vector<unsigned char> pixels(30 * 20 * 3);
  ASSERT_TRUE(image->write_image(OIIO::TypeUInt8, pixels.data()));
  image->close();
  std::ofstream(folder / "transforms.json")
      << R"({"camera_angle_x": 1.5707963267948966, "frames": [{"file_path": "./r_0",
    "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]})";
  const CameraSet set = read_cameras(folder / "transforms.json");
  EXPECT_EQ(set.cameras[0].camera.width, 30);
  EXPECT_EQ(set.cameras[0].camera.height, 20);
  EXPECT_NEAR(set.cameras[0].camera.fx, 15.0, 1e-12);
  std::filesystem::remove_all(folder);
}

TEST(ImageFileSizeTest, png_and_jpeg_tell_their_size) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "alidade_image_size";
  std::filesystem::create_directories(folder);
  for (const std::string name : {"a.png", "a.jpg"}) {
    const auto image = OIIO::ImageOutput::create((folder / name).string());
    const OIIO::ImageSpec spec(300, 17, 3, OIIO::TypeUInt8);
    ASSERT_TRUE(image->open((folder / name).string(), spec));
    const std::vector<unsigned char> pixels(300 * 17 * 3);
    ASSERT_TRUE(image->write_image(OIIO::TypeUInt8, pixels.data()));
    image->close();
    EXPECT_EQ(image_file_size(folder / name).width, 300u) << name;
    EXPECT_EQ(image_file_size(folder / name).height, 17u) << name;
    // Cut off anywhere it is an error, or still tells the same.
    std::ifstream stream(folder / name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      InputFile cut(std::as_bytes(std::span(bytes).first(size)), "cut");
      try {
        EXPECT_EQ(image_file_size(cut).width, 300u);
      } catch (const Error&) {
      }
    }
  }
  std::ofstream(folder / "b.png") << "no picture";
  EXPECT_THROW(image_file_size(folder / "b.png"), Error);
  EXPECT_THROW(image_file_size(folder / "c.png"), Error);
  std::filesystem::remove_all(folder);
}

// ---- OpenSfM ----

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

TEST(OpenSfm, further_reconstructions_are_left_out_and_it_is_said) {
  const std::string one = opensfm(R"({"width": 640, "height": 480, "focal": 0.8})");
  const CameraSet set = parse(fmt::format("[{},{}", one.substr(1, one.size() - 2), one.substr(1)));
  EXPECT_EQ(set.cameras.size(), 2u);
  EXPECT_NE(set.warnings.at(0).find("only the first of 2 reconstructions"), std::string::npos);
}

TEST(OpenSfm, damage_is_an_error_at_its_place) {
  expect_error(opensfm(R"({"width": 640, "height": 480, "focal": 0})"),
               "number out of range (at /0/cameras/one/focal)");
  expect_error(opensfm(R"({"width": 640, "height": 480})"), "missing key \"focal_x\"");
  expect_error(opensfm(R"({"width": 640, "focal": 0.8})"), "missing key \"height\"");
  expect_error(opensfm(R"({"projection_type": "pinhole", "width": 640, "height": 480, "focal": 0.8})"),
               "unknown word");
  const std::string good = opensfm(R"({"width": 640, "height": 480, "focal": 0.8})");
  expect_error(replaced(good, "\"camera\": \"one\"", "\"camera\": \"two\""),
               "no such camera (at /0/shots/b.jpg/camera)");
  expect_error(replaced(good, "[0, 0, 1.5707963267948966]", "[0, 0, 1e300]"), "number out of range");
  expect_error(replaced(good, "[1, 2, 3]}", "[1, 2]}"), "wrong number of values");
  expect_error("[{\"cameras\": {}, \"shots\": {}}]", "holds no camera with a pose");
}

// ---- openMVG ----

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

TEST(OpenMvg, damage_is_an_error_at_its_place) {
  expect_error(
      replaced(k_openmvg, "[[0, -1, 0], [0, 0, -1], [1, 0, 0]]", "[[0, -1, 0], [0, 0, -1], [0, 0, 0]]"),
      "not a rotation (at /extrinsics/0/value/rotation)");
  expect_error(replaced(k_openmvg, "\"focal_length\": 500", "\"focal_length\": 0"), "number out of range");
  expect_error(replaced(k_openmvg, "\"pinhole_radial_k3\"", "\"pinhole_9\""),
               "unknown kind of camera (at /intrinsics/0/value)");
  expect_error(replaced(k_openmvg, "\"polymorphic_id\": 1,", "\"polymorphic_id\": 5,"), "no such type");
  expect_error(replaced(k_openmvg, "\"id_intrinsic\": 1", "\"id_intrinsic\": 8"), "no such intrinsic");
  expect_error(replaced(k_openmvg, "\"disto_k3\": [0.1, 0.02, 0.003]", "\"disto_k3\": [0.1]"),
               "wrong number of values");
  expect_error(R"({"sfm_data_version": "0.3"})", "holds no camera with a pose");
}

// ---- trajectories ----

CameraFileOptions with_lens() {
  return {.lens = pinhole_from_fov(60, 40, 50.0, {}), .original_world = false};
}

CameraSet trajectory(const std::string& text) {
  return parse_cameras(text, "nowhere/flight.csv", with_lens());
}

std::string trajectory_error(const std::string& text, const CameraFileOptions& options = with_lens()) {
  try {
    parse_cameras(text, "flight.csv", options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

const std::string k_header = "# opencv, camera_to_world\ntime,x,y,z,qw,qx,qy,qz\n";

TEST(Trajectory, rows_are_poses_in_their_order) {
  const CameraSet set = trajectory(k_header + "2.5,7,8,9,1,0,0,0\n\n1.5, 1, 2, 3, 0, 2, 0, 0\r\n");
  ASSERT_EQ(set.cameras.size(), 2u);
  EXPECT_EQ(set.cameras[0].name, "2.5");
  EXPECT_EQ(set.cameras[1].name, "1.5");
  expect_pose(set.cameras[0].camera.pose, {{7, 8, 9}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  expect_pose(set.cameras[1].camera.pose, {{1, 2, 3}, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  EXPECT_EQ(set.cameras[0].camera.width, 60);
  EXPECT_EQ(set.cameras[0].camera.fx, with_lens().lens->fx);
}

TEST(Trajectory, conventions_and_directions_are_as_the_remark_says) {
  // A quarter turn about z.
  const std::string row = "name x y z qx qy qz qw time\nstart 1 2 3 0 0 1 1 0\n";
  expect_pose(trajectory("# opencv camera_to_world\n" + row).cameras[0].camera.pose,
              {{1, 2, 3}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 1}});
  expect_pose(trajectory("# opengl camera_to_world\n" + row).cameras[0].camera.pose,
              {{1, 2, 3}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}});
  expect_pose(trajectory("# opencv\n#world_to_camera\n" + row).cameras[0].camera.pose,
              {{-2, 1, -3}, {0, -1, 0}, {1, 0, 0}, {0, 0, 1}});
  EXPECT_EQ(trajectory("# opencv camera_to_world\n" + row).cameras[0].name, "start");
}

TEST(Trajectory, nothing_is_guessed) {
  EXPECT_NE(trajectory_error("time,x,y,z,qw,qx,qy,qz\n")
                .find("flight.csv:line 1: nothing says how the quaternions are meant"),
            std::string::npos);
  EXPECT_NE(trajectory_error("# opencv\ntime,x,y,z,qw,qx,qy,qz\n").find("nothing says"), std::string::npos);
  EXPECT_NE(trajectory_error("# opencv camera_to_world\n1,2,3,4,1,0,0,0\n").find("no column 'time'"),
            std::string::npos);
  EXPECT_NE(trajectory_error("# opencv camera_to_world\ntime,x,y,z,qw,qx,qy\n").find("no column 'qz'"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,3,4,1,0,0,0\n", {}).find("a trajectory has no lens"),
            std::string::npos);
}

TEST(Trajectory, damage_is_an_error_at_its_line) {
  EXPECT_NE(trajectory_error(k_header + "1,2,3,4,1,0,0\n").find("flight.csv:line 3: row without 'qz'"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,3,4,0,0,0,0\n").find("quaternion is none"), std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,x,4,1,0,0,0\n").find("bad y; expected a number, found 'x'"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,inf,4,1,0,0,0\n").find("bad y"), std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,1e13,4,1,0,0,0\n").find("place is out of range"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header + "1,2,3,4,1,0,0,0\n1,2,3,4,1,0,0,0\n").find("camera '1' stands twice"),
            std::string::npos);
  EXPECT_NE(trajectory_error(k_header).find("holds no camera with a pose"), std::string::npos);
  EXPECT_NE(trajectory_error("").find("holds no camera with a pose"), std::string::npos);
  EXPECT_NE(trajectory_error("# opencv camera_to_world\ntime,x,x,z\n").find("column 'x' stands twice"),
            std::string::npos);
}

}  // namespace
}  // namespace alidade::test
