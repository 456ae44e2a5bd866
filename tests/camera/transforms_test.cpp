// SPDX-License-Identifier: MIT
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <filesystem>

#include <cmath>
#include <fstream>
#include <numbers>
#include <span>

#include "camera/formats/camera_file.h"
#include "camera/projection.h"
#include "tests/camera/camera_file_text.h"
#include "tests/renderer/describe_scene.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

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
  // x_json = s (A x + a); the camera that saw x there must see it here at the same position of the film.
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
  expect_error(replaced(k_transforms, "\"fl_x\": 500, \"fl_y\": 510,", ""), "missing focal length");
}

TEST(TransformsJson, lenses_are_detected_by_model_and_flag) {
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
  EXPECT_NE(ngp.warnings.at(0).find("ignoring k3 and k4: they require \"camera_model\" or \"is_fisheye\""),
            std::string::npos);
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
  expect_error(replaced(k_transforms, "\"OPENCV\"", "\"FISHEYE624\""), "unknown value");
}

TEST(TransformsJson, a_frames_own_value_is_used_and_a_contradiction_is_reported) {
  const CameraSet set = parse(replaced(k_transforms, "\"file_path\": \"images/a.jpg\"",
                                       "\"file_path\": \"images/a.jpg\", \"fl_x\": 600"));
  EXPECT_EQ(set.cameras[0].camera.fx, 600.0);
  EXPECT_EQ(set.cameras[1].camera.fx, 500.0);
  EXPECT_NE(set.warnings.at(0).find("\"fl_x\" differs between the file and its frames"), std::string::npos);
}

TEST(TransformsJson, a_scaled_pose_loses_its_scale_with_a_warning) {
  const CameraSet set =
      parse(replaced(k_transforms, "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9], [0, 0, 0, 1]]",
                     "[[3, 0, 0, 7], [0, 3, 0, 8], [0, 0, 3, 9], [0, 0, 0, 1]]"));
  expect_pose(set.cameras[1].camera.pose, {{7, 8, 9}, {1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
  EXPECT_NE(set.warnings.at(0).find("removed the scale of 1 poses"), std::string::npos);
}

TEST(TransformsJson, damage_is_an_error_at_its_location) {
  expect_error(replaced(k_transforms, "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9]",
                        "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 1, 0, 9]"),
               "invalid rotation (at /frames/0/transform_matrix)");
  expect_error(replaced(k_transforms, "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9]",
                        "[[0, 0, 0, 7], [0, 0, 0, 8], [0, 0, 0, 9]"),
               "invalid rotation");
  expect_error(replaced(k_transforms, "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, 1, 9]",
                        "[[1, 0, 0, 7], [0, 1, 0, 8], [0, 0, -1, 9]"),
               "invalid rotation");
  expect_error(replaced(k_transforms, "\"fl_x\": 500", "\"fl_x\": 0"), "number out of range (at /fl_x)");
  expect_error(replaced(k_transforms, "\"w\": 640", "\"w\": 0"), "number out of range (at /w)");
  expect_error(replaced(k_transforms, "\"file_path\": \"images/a.jpg\"", "\"file\": 1"),
               "missing key \"file_path\"");
  expect_error(replaced(k_transforms, "images/a.jpg", "images/b.jpg"), "duplicate camera 'images/b.jpg'");
  expect_error(R"({"frames": []})", "contains no camera with a pose");
  // Without a size the image must be there.
  expect_error(replaced(k_transforms, "\"w\": 640, ", ""),
               "unknown image size, and the image file is missing (at /frames/0)");
}

TEST(TransformsJson, a_missing_size_is_that_of_the_image) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "alidade_transforms";
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

TEST(ImageFileSizeTest, png_and_jpeg_have_their_size) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "alidade_image_size";
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
    // A file cut off anywhere is an error or gives the same size.
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

}  // namespace
}  // namespace alidade::test
