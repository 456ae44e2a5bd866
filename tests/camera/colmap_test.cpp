// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <filesystem>

#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <span>

#include "base/error.h"
#include "camera/formats/camera_file.h"
#include "camera/projection.h"
#include "tests/camera/colmap_builder.h"
#include "tests/renderer/describe_scene.h"

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;

namespace {

CameraSet read(const std::string& cameras, const std::string& images) {
  return read_colmap_binary(InputFile(std::as_bytes(std::span(cameras)), "cameras.bin"),
                            InputFile(std::as_bytes(std::span(images)), "images.bin"));
}
CameraSet read(const ColmapBuilder& model) {
  return read(model.cameras(), model.images());
}
CameraSet read_text(const std::string& cameras, const std::string& images) {
  return read_colmap_text(cameras, "cameras.txt", images, "images.txt");
}

std::string error_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void expect_error(const std::function<void()>& work, const std::string& part) {
  const std::string text = error_of(work);
  EXPECT_NE(text.find(part), std::string::npos) << text << "\n  lacks " << part;
}

ColmapBuilder small_model() {
  ColmapBuilder model;
  model.camera(1, 1, 640, 480, {500.0, 510.0, 320.0, 240.0});
  model.image(7, {1.0, 0.0, 0.0, 0.0}, {1.0, 2.0, 3.0}, 1, "b.jpg", 3);
  model.image(3, {0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 1, "folder/a.jpg");
  return model;
}

TEST(Colmap, poses_turn_the_world_into_the_camera) {
  const CameraSet set = read(small_model());
  ASSERT_EQ(set.cameras.size(), 2u);
  const Camera& camera = set.cameras[0].camera;
  EXPECT_EQ(set.cameras[0].name, "b.jpg");
  EXPECT_EQ(camera.pose.position, glm::dvec3(-1.0, -2.0, -3.0));
  EXPECT_EQ(camera.pose.right, glm::dvec3(1.0, 0.0, 0.0));
  EXPECT_EQ(camera.pose.down, glm::dvec3(0.0, 1.0, 0.0));
  EXPECT_EQ(camera.pose.forward, glm::dvec3(0.0, 0.0, 1.0));
  // Half a turn about x.
  EXPECT_EQ(set.cameras[1].camera.pose.forward, glm::dvec3(0.0, 0.0, -1.0));
  EXPECT_EQ(set.cameras[1].camera.pose.right, glm::dvec3(1.0, 0.0, 0.0));
}

// A turn of 90 degrees about z, w = z = sqrt(1/2): x of the world becomes y of the camera. Any length will
// do.
TEST(Colmap, quaternions_are_hamiltons_with_w_first) {
  ColmapBuilder model;
  model.camera(1, 0, 10, 10, {5.0, 5.0, 5.0}).image(1, {3.0, 0.0, 0.0, 3.0}, {0.0, 0.0, 0.0}, 1, "a");
  const CameraPose pose = read(model).cameras[0].camera.pose;
  // Rows of the rotation are the camera's axes in the world.
  EXPECT_LT(glm::length(pose.down - glm::dvec3(1.0, 0.0, 0.0)), 1e-15);
  EXPECT_LT(glm::length(pose.right - glm::dvec3(0.0, -1.0, 0.0)), 1e-15);
}

/// Where the camera of a model, with numbered parameters, sees the direction (0.2, -0.1, 1).
glm::dvec2 seen_by(int id, const std::vector<double>& parameters) {
  ColmapBuilder model;
  model.camera(1, id, 640, 480, parameters).image(1, {1.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 1, "a");
  return Projection(read(model).cameras[0].camera).project({0.2, -0.1, 1.0}).value();
}

// Each parameter in its slot: the documented formulas by hand, at u = 0.2, v = -0.1.
TEST(Colmap, parameters_of_every_model_have_their_index) {
  const double u = 0.2, v = -0.1, r2 = 0.05, r = std::sqrt(r2), theta = std::atan(r);
  const double a = u * theta / r, b = v * theta / r, q = theta * theta;
  const auto expect = [&](int id, const std::vector<double>& tail, double ud, double vd) {
    const bool one = id == 0 || id == 2 || id == 3 || id == 8 || id == 9 || id == 12 || id == 14;
    std::vector<double> all = one ? std::vector<double>{500.0} : std::vector<double>{500.0, 400.0};
    all.insert(all.end(), {321.0, 243.0});
    all.insert(all.end(), tail.begin(), tail.end());
    const glm::dvec2 film = seen_by(id, all);
    EXPECT_NEAR(film.x, 321.0 + 500.0 * ud, 1e-10) << id;
    EXPECT_NEAR(film.y, 243.0 + (one ? 500.0 : 400.0) * vd, 1e-10) << id;
  };
  expect(0, {}, u, v);
  expect(1, {}, u, v);
  expect(2, {0.1}, u * (1 + 0.1 * r2), v * (1 + 0.1 * r2));
  const double two = 1 + 0.1 * r2 + 0.2 * r2 * r2;
  expect(3, {0.1, 0.2}, u * two, v * two);
  const double p1 = 0.01, p2 = 0.02;
  const double bend_u = 2 * p1 * u * v + p2 * (r2 + 2 * u * u),
               bend_v = 2 * p2 * u * v + p1 * (r2 + 2 * v * v);
  expect(4, {0.1, 0.2, p1, p2}, u * two + bend_u, v * two + bend_v);
  const double four = 1 + 0.1 * q + 0.2 * q * q + 0.3 * q * q * q + 0.4 * q * q * q * q;
  expect(5, {0.1, 0.2, 0.3, 0.4}, a * four, b * four);
  const double full = (two + 0.3 * r2 * r2 * r2) / (1 + 0.4 * r2 + 0.5 * r2 * r2 + 0.6 * r2 * r2 * r2);
  expect(6, {0.1, 0.2, p1, p2, 0.3, 0.4, 0.5, 0.6}, u * full + bend_u, v * full + bend_v);
  const double fov = std::atan(2 * r * std::tan(0.45)) / (r * 0.9);
  expect(7, {0.9}, u * fov, v * fov);
  expect(8, {0.1}, a * (1 + 0.1 * q), b * (1 + 0.1 * q));
  expect(9, {0.1, 0.2}, a * (1 + 0.1 * q + 0.2 * q * q), b * (1 + 0.1 * q + 0.2 * q * q));
  const double fish_u = 2 * p1 * a * b + p2 * (q + 2 * a * a), fish_v = 2 * p2 * a * b + p1 * (q + 2 * b * b);
  expect(10, {0.1, 0.2, p1, p2, 0.3, 0.4, 0.05, 0.06}, a * four + fish_u + 0.05 * q,
         b * four + fish_v + 0.06 * q);
  double six = 1.0;
  for (int i = 0; i < 6; ++i) six += 0.01 * (i + 1) * std::pow(q, i + 1);
  const double c = a * six, d = b * six, s = c * c + d * d;
  expect(11, {0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.11, 0.12, 0.13, 0.14},
         c + 2 * 0.08 * c * d + 0.07 * (s + 2 * c * c) + 0.11 * s + 0.12 * s * s,
         d + 2 * 0.07 * c * d + 0.08 * (s + 2 * d * d) + 0.13 * s + 0.14 * s * s);
  const double division = 2 / (1 + std::sqrt(1 - 4 * -0.2 * r2));
  expect(12, {-0.2}, u * division, v * division);
  expect(13, {-0.2}, u * division, v * division);
  expect(14, {}, a, b);
  expect(15, {}, a, b);
  const double unified = 0.6 * std::sqrt(1.1 * r2 + 1) + 0.4;
  expect(16, {0.6, 1.1}, u / unified, v / unified);
}

TEST(Colmap, a_panorama_covers_its_image) {
  const glm::dvec2 film = seen_by(17, {640.0, 480.0});
  EXPECT_NEAR(film.x, (std::atan2(0.2, 1.0) / (2 * std::numbers::pi) + 0.5) * 640.0, 1e-10);
  EXPECT_NEAR(film.y, (0.5 - std::atan2(0.1, std::hypot(0.2, 1.0)) / std::numbers::pi) * 480.0, 1e-10);
}

const std::string k_cameras_text =
    "# Camera list\n1 OPENCV 640 480 500 510 320 240 0.1 0.01 0.001 -0.002\r\n\n2, PINHOLE, 640, 480, 500, "
    "510, 320, 240\n";
const std::string k_images_text =
    "# Image list\n3 1 0 0 0 0.5 1.5 2.5 1 my photo, no 1.jpg\n1.5 2.5 -1 3.5 4.5 17\n4 0 1 0 0 0 0 0 2 "
    "b.jpg\n\n5 0 1 0 0 0 0 0 2 "
    "c.jpg\n";

TEST(Colmap, text_and_binary_give_the_same_cameras) {
  ColmapBuilder model;
  model.camera(1, 4, 640, 480, {500, 510, 320, 240, 0.1, 0.01, 0.001, -0.002});
  model.camera(2, 1, 640, 480, {500, 510, 320, 240});
  model.image(3, {1, 0, 0, 0}, {0.5, 1.5, 2.5}, 1, "my photo, no 1.jpg", 2);
  model.image(4, {0, 1, 0, 0}, {0, 0, 0}, 2, "b.jpg");
  model.image(5, {0, 1, 0, 0}, {0, 0, 0}, 2, "c.jpg");
  const CameraSet binary = read(model), text = read_text(k_cameras_text, k_images_text);
  ASSERT_EQ(binary.cameras.size(), text.cameras.size());
  for (std::size_t i = 0; i < text.cameras.size(); ++i) {
    EXPECT_EQ(binary.cameras[i].name, text.cameras[i].name);
    EXPECT_EQ(describe(binary.cameras[i].camera), describe(text.cameras[i].camera));
  }
}

TEST(Colmap, every_cut_of_a_binary_file_is_an_error) {
  const std::string cameras = small_model().cameras(), images = small_model().images();
  EXPECT_EQ(error_of([&] { read(cameras, images); }), "no error");
  for (std::size_t size = 0; size < cameras.size(); ++size)
    expect_error([&] { read(cameras.substr(0, size), images); }, "cameras.bin");
  for (std::size_t size = 0; size < images.size(); ++size)
    expect_error([&] { read(cameras, images.substr(0, size)); }, "images.bin");
  expect_error([&] { read(cameras + "x", images); }, "extra bytes after the last record");
  expect_error([&] { read(cameras, images + "x"); }, "extra bytes after the last record");
}

TEST(Colmap, counts_beyond_the_file_are_errors_before_memory_is_taken) {
  std::string many;
  ColmapBuilder::append(many, UINT64_MAX);
  const ColmapBuilder model = small_model();
  expect_error([&] { read(many, model.images()); },
               "cameras.bin:byte 0: the number of cameras exceeds the file; expected at most 0, found "
               "18446744073709551615");
  expect_error([&] { read(model.cameras(), many); },
               "images.bin:byte 0: the number of images exceeds the file");
  std::string observations = model.images();
  // The count of observations of the first image follows its name "b.jpg".
  const std::size_t offset = 8 + 4 + 7 * 8 + 4 + 6;
  observations[offset + 7] = '\x7f';
  expect_error([&] { read(model.cameras(), observations); }, "the number of observations exceeds the file");
}

TEST(Colmap, damaged_models_are_errors_with_their_location) {
  const auto with = [](const std::function<void(ColmapBuilder&)>& change) {
    return [change] {
      ColmapBuilder model = small_model();
      change(model);
      read(model);
    };
  };
  expect_error(with([](auto& m) {
                 m.camera(2, 18, 640, 480, {1, 2, 3});
               }),
               "cameras.bin:byte 64: unknown model of camera 2; expected a model id from 0 to 17, found 18");
  expect_error(with([](auto& m) { m.camera(1, 0, 640, 480, {500, 320, 240}); }), "duplicate camera id 1");
  expect_error(with([](auto& m) { m.camera(2, 0, 640, 480, {0.0, 320, 240}); }), "focal length out of range");
  expect_error(with([](auto& m) { m.camera(2, 0, 640, 480, {NAN, 320, 240}); }), "focal length out of range");
  expect_error(with([](auto& m) { m.camera(2, 0, 0, 480, {500, 320, 240}); }), "image size out of range");
  expect_error(with([](auto& m) {
                 m.camera(2, 0, UINT64_MAX, 2, {500, 320, 240});
               }),
               "image size out of range");
  expect_error(with([](auto& m) {
                 m.image(9, {1, 0, 0, 0}, {0, 0, 0}, 4, "c");
               }),
               "image 9 refers to the missing camera 4");
  expect_error(with([](auto& m) { m.image(7, {1, 0, 0, 0}, {0, 0, 0}, 1, "c"); }), "duplicate image id 7");
  expect_error(with([](auto& m) {
                 m.image(9, {0, 0, 0, 0}, {0, 0, 0}, 1, "c");
               }),
               "invalid rotation of image 9");
  expect_error(with([](auto& m) {
                 m.image(9, {NAN, 0, 0, 0}, {0, 0, 0}, 1, "c");
               }),
               "invalid rotation of image 9");
  expect_error(with([](auto& m) {
                 m.image(9, {1, 0, 0, 0}, {0, INFINITY, 0}, 1, "c");
               }),
               "translation of image 9");
  expect_error(with([](auto& m) { m.image(9, {1, 0, 0, 0}, {0, 0, 0}, 1, ""); }), "image 9 has no name");
  expect_error(with([](auto& m) {
                 m.image(9, {1, 0, 0, 0}, {0, 0, 0}, 1, std::string(5000, 'x'));
               }),
               "unterminated name");
}

TEST(Colmap, damaged_texts_are_errors_with_their_line) {
  const auto cameras = [](const std::string& text) { return [text] { read_text(text, ""); }; };
  expect_error(cameras("1 PINHOLE 640 480 500 510 320"), "cameras.txt:line 1: invalid camera parameter");
  expect_error(cameras("\n1 PINHOLE 640 480 500 510 320 240 1"),
               "cameras.txt:line 2: camera 1 has too many parameters");
  expect_error(cameras("1 PINHOEL 640 480 500 510 320 240"), "unknown model of camera");
  expect_error(cameras("x PINHOLE 640 480 500 510 320 240"),
               "invalid camera id; expected an integer from 0 to 4294967295, found 'x'");
  expect_error(cameras("1 PINHOLE 640 480 500 51o 320 240"), "found '51o'");
  expect_error(cameras("1 PINHOLE 640 480 500 nan 320 240"), "invalid camera parameter");
  expect_error(cameras("1 PINHOLE 640 480 500 0 320 240"), "focal length out of range");
  const auto images = [](const std::string& text) { return [text] { read_text(k_cameras_text, text); }; };
  expect_error(images("3 1 0 0 0 0.5 1.5 2.5 1"), "image 3 has no name");
  expect_error(images("3 1 0 0 0 0.5 1.5"), "images.txt:line 1: invalid translation");
  expect_error(images("3 0 0 0 0 0.5 1.5 2.5 1 a"), "invalid rotation of image 3");
  expect_error(images("3 1 0 0 0 0 0 0 1 a\n1 2 3 4\n"), "images.txt:line 2: invalid line of observations");
  expect_error(images("3 1 0 0 0 0 0 0 1 a\n1 2 three\n"), "images.txt:line 2: invalid line of observations");
}

TEST(Colmap, lines_of_observations_may_be_missing) {
  const auto names_of = [](const std::string& text) {
    std::vector<std::string> names;
    for (const NamedCamera& each : read_text(k_cameras_text, text).cameras) names.push_back(each.name);
    return names;
  };
  const std::string a = "3 1 0 0 0 0 0 0 1 a", b = "4 0.5 0.5 -0.5 0.5 1 2 3 1 sub dir/photo 2.JPG",
                    c = "5 1 0 0 0 0 0 0 1 c";
  const std::vector<std::string> expected = {"a", "sub dir/photo 2.JPG", "c"};
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    EXPECT_EQ(names_of(a + end + b + end + c + end), expected);
    EXPECT_EQ(names_of(a + end + end + b + end + end + c), expected);
    EXPECT_EQ(
        names_of(a + end + "1.5 2.5 -1 3 4 18446744073709551615" + end + b + end + c + end + "1 2 3" + end),
        expected);
    EXPECT_EQ(names_of("# remark" + end + a + end + b + end + end + "# remark" + end + c), expected);
  }
}

class ColmapFolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / "alidade_colmap";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }
  std::filesystem::path folder_;
};

TEST_F(ColmapFolderTest, a_folder_is_a_model_and_binary_files_win) {
  EXPECT_THROW(read_cameras(folder_), Error);
  write("cameras.txt", k_cameras_text);
  EXPECT_THROW(read_cameras(folder_), Error);
  write("images.txt", k_images_text);
  EXPECT_EQ(read_cameras(folder_).cameras.size(), 3u);
  write("cameras.bin", small_model().cameras());
  write("images.bin", small_model().images());
  const CameraSet set = read_cameras(folder_);
  ASSERT_EQ(set.cameras.size(), 2u);
  EXPECT_EQ(set.cameras[0].name, "b.jpg");  // by name
  EXPECT_EQ(set.cameras[1].name, "folder/a.jpg");
}

TEST_F(ColmapFolderTest, a_model_without_images_is_an_error) {
  write("cameras.txt", k_cameras_text);
  write("images.txt", "# nothing\n");
  expect_error([&] { read_cameras(folder_); }, "contains no camera with a pose");
}

TEST_F(ColmapFolderTest, a_camera_is_found_by_name_file_name_or_stem) {
  write("cameras.bin", small_model().image(9, {1, 0, 0, 0}, {0, 0, 0}, 1, "other/b.jpg").cameras());
  write("images.bin", small_model().image(9, {1, 0, 0, 0}, {0, 0, 0}, 1, "other/b.jpg").images());
  const CameraSet set = read_cameras(folder_);
  EXPECT_EQ(camera_called(set, "b.jpg", "model").name, "b.jpg");  // exactly
  EXPECT_EQ(camera_called(set, "a.jpg", "model").name, "folder/a.jpg");
  EXPECT_EQ(camera_called(set, "a", "model").name, "folder/a.jpg");
  expect_error([&] { camera_called(set, "b", "model"); }, "model: several cameras named 'b'");
  expect_error([&] { camera_called(set, "folder/aa.jpg", "model"); },
               "no camera named 'folder/aa.jpg'; expected one of 3 names such as 'folder/a.jpg'");
}

}  // namespace
}  // namespace alidade::test
