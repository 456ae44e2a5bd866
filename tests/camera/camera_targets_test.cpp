// SPDX-License-Identifier: MIT
// Small balls are rendered through cameras of every lens and every file format, and found where a formula
// puts them: half pixels, axes and directions cannot be wrong together in an image and in a formula written
// without them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>

#include "camera/camera.h"
#include "camera/formats/camera_file.h"
#include "camera/projection.h"
#include "renderer/render.h"
#include "tests/camera/lens_cases.h"
#include "tests/support/random.h"

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

/// Middle of the pixels that show each object, in pixels; only objects that do not touch the image's edge.
std::map<std::size_t, glm::dvec2> middles(const Film& film) {
  std::map<std::size_t, glm::dvec2> sums;
  std::map<std::size_t, int> counts;
  std::map<std::size_t, bool> cut;
  for (int y = 0; y < film.height; ++y) {
    for (int x = 0; x < film.width; ++x) {
      const std::uint32_t id = film.id[film.index(x, y)];
      if (id == 0) continue;
      const std::size_t object = ~id;
      sums[object] += glm::dvec2(x + 0.5, y + 0.5);
      ++counts[object];
      if (x == 0 || y == 0 || x == film.width - 1 || y == film.height - 1) cut[object] = true;
    }
  }
  std::map<std::size_t, glm::dvec2> result;
  for (const auto& [object, sum] : sums) {
    if (!cut[object]) result[object] = sum / static_cast<double>(counts[object]);
  }
  return result;
}

Film image_of(const Camera& camera, const std::vector<glm::dvec3>& targets, double radius) {
  Scene scene;
  scene.sky = ConstantSky{};
  scene.render.samples = 1;
  scene.render.max_bounces = 0;
  scene.camera = camera;
  for (const glm::dvec3& each : targets) scene.objects.push_back(Sphere{each, radius, Emissive{Rgb(1.0f)}});
  return render(scene, nullptr);
}

TEST(CameraTargets, every_lens_shows_a_ball_where_it_projects_it) {
  Random random;
  for (const auto& [name, camera] : lens_cases()) {
    const bool parallel = std::holds_alternative<OrthographicLens>(camera.lens);
    const Projection projection(camera);
    std::vector<glm::dvec3> targets;
    while (targets.size() < 25) {
      const glm::dvec3 position = camera.pose.position + 10.0 * random.direction();
      const auto film = projection.project(position);
      if (film && film->x > 20 && film->y > 20 && film->x < 620 && film->y < 460) targets.push_back(position);
    }
    // Balls of about three pixels, ten metres away.
    const double radius = (parallel ? 3.0 : 30.0) / camera.fx;
    const auto found = middles(image_of(camera, targets, radius));
    glm::dvec2 sum(0.0);
    int count = 0;
    for (const auto& [object, middle] : found) {
      // Balls may hide each other, and one that a strong lens draws out has its middle elsewhere.
      const bool alone = std::ranges::none_of(targets, [&](const glm::dvec3& other) {
        return other != targets[object] && glm::length(*projection.project(other) - middle) < 40.0;
      });
      if (!alone) continue;
      ++count;
      const glm::dvec2 error = middle - *projection.project(targets[object]);
      sum += error;
      EXPECT_LT(glm::length(error), 0.45) << name;
    }
    ASSERT_GE(count, 5) << name;
    // Half a pixel would show in the mean of all.
    EXPECT_LT(glm::length(sum / static_cast<double>(count)), 0.2) << name;
  }
}

// One camera of this world in the words of each format. It is at (3, -5, 2) and looks north-west and a
// little down. Pixel positions come from the formats' own words: u = fx x / z + cx with x = R (X - C).

constexpr double k_focal = 300.0, k_cx = 141.25, k_cy = 97.5;

struct World {
  glm::dvec3 center{3.0, -5.0, 2.0};
  glm::dmat3 rotation;  ///< world to camera
};

World world() {
  const CameraPose pose = look_at({3.0, -5.0, 2.0}, {-4.0, 2.0, 1.0});
  World result;
  for (int axis = 0; axis < 3; ++axis) {
    result.rotation[axis] = {pose.right[axis], pose.down[axis], pose.forward[axis]};
  }
  return result;
}

std::string number_list(std::initializer_list<double> numbers) {
  std::string text;
  for (const double each : numbers) text += fmt::format("{}{:.17g}", text.empty() ? "" : ",", each);
  return text;
}

std::string row(const glm::dmat3& matrix, int index) {
  return number_list({matrix[0][index], matrix[1][index], matrix[2][index]});
}

/// w, x, y, z of a rotation, by the sizes of its components.
std::array<double, 4> quaternion_of(const glm::dmat3& r) {
  const double w = 0.5 * std::sqrt(1.0 + r[0][0] + r[1][1] + r[2][2]);
  return {w, (r[1][2] - r[2][1]) / (4 * w), (r[2][0] - r[0][2]) / (4 * w), (r[0][1] - r[1][0]) / (4 * w)};
}

glm::dvec3 axis_angle_of(const glm::dmat3& r) {
  const auto [w, x, y, z] = quaternion_of(r);
  const double length = std::sqrt(x * x + y * y + z * z);
  return glm::dvec3(x, y, z) * (2.0 * std::atan2(length, w) / length);
}

Camera from_colmap() {
  const World w = world();
  const auto q = quaternion_of(w.rotation);
  const glm::dvec3 t = -(w.rotation * w.center);
  return read_colmap_text(
             fmt::format("1 PINHOLE 280 200 {0} {0} {1} {2}\n", k_focal, k_cx, k_cy), "cameras.txt",
             fmt::format("1 {} 1 a.jpg\n\n", number_list({q[0], q[1], q[2], q[3], t.x, t.y, t.z})),
             "images.txt")
      .cameras[0]
      .camera;
}

Camera from_transforms() {
  const World w = world();
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    rows += fmt::format("[{}],",
                        number_list({w.rotation[i][0], -w.rotation[i][1], -w.rotation[i][2], w.center[i]}));
  }
  return parse_cameras(
             fmt::format(
                 R"({{"w": 280, "h": 200, "fl_x": {}, "cx": {}, "cy": {}, "frames": [{{"file_path": "a.jpg",
           "transform_matrix": [{} [0, 0, 0, 1]]}}]}})",
                 k_focal, k_cx, k_cy, rows),
             "transforms.json")
      .cameras[0]
      .camera;
}

Camera from_opensfm() {
  const World w = world();
  const glm::dvec3 turn = axis_angle_of(w.rotation), t = -(w.rotation * w.center);
  return parse_cameras(
             fmt::format(
                 R"([{{"cameras": {{"c": {{"projection_type": "brown", "width": 280, "height": 200, "focal_x": {0:.17g},
               "focal_y": {0:.17g}, "c_x": {1:.17g}, "c_y": {2:.17g}}}}}, "shots": {{"a.jpg": {{"camera": "c", "rotation": [{3}],
               "translation": [{4}]}}}}}}])",
                 k_focal / 280.0, (k_cx - 140.0) / 280.0, (k_cy - 100.0) / 280.0,
                 number_list({turn.x, turn.y, turn.z}), number_list({t.x, t.y, t.z})),
             "reconstruction.json")
      .cameras[0]
      .camera;
}

// Its pixel centres are whole numbers, so that the same camera has its principal point half a pixel less.
Camera from_openmvg() {
  const World w = world();
  return parse_cameras(
             fmt::format(
                 R"({{"sfm_data_version": "0.3", "views": [{{"key": 0, "value": {{"ptr_wrapper": {{"id": 2147483649, "data":
               {{"filename": "a.jpg", "id_intrinsic": 0, "id_pose": 0}}}}}}}}], "intrinsics": [{{"key": 0, "value": {{
               "polymorphic_id": 2147483649, "polymorphic_name": "pinhole", "ptr_wrapper": {{"id": 2147483650, "data": {{"width": 280,
               "height": 200, "focal_length": {}, "principal_point": [{}, {}]}}}}}}}}], "extrinsics": [{{"key": 0, "value": {{
               "rotation": [[{}], [{}], [{}]], "center": [{}]}}}}]}})",
                 k_focal, k_cx - 0.5, k_cy - 0.5, row(w.rotation, 0), row(w.rotation, 1), row(w.rotation, 2),
                 number_list({w.center.x, w.center.y, w.center.z})),
             "sfm_data.json")
      .cameras[0]
      .camera;
}

Camera from_trajectory() {
  const World w = world();
  const auto q = quaternion_of(glm::transpose(w.rotation));
  Camera lens{.width = 280, .height = 200, .fx = k_focal, .fy = k_focal, .cx = k_cx, .cy = k_cy, .pose = {}};
  return parse_cameras(fmt::format("# opencv camera_to_world\ntime,x,y,z,qw,qx,qy,qz\n0,{}\n",
                                   number_list({w.center.x, w.center.y, w.center.z, q[0], q[1], q[2], q[3]})),
                       "flight.csv", {.lens = lens, .original_world = false})
      .cameras[0]
      .camera;
}

TEST(CameraTargets, cameras_of_every_format_show_a_ball_where_the_formula_says) {
  const World w = world();
  Random random;
  std::vector<glm::dvec3> targets;
  for (int i = 0; i < 60; ++i) targets.push_back(glm::dvec3(-4.0, 2.0, 1.0) + 6.0 * random.in_cube());
  const std::pair<const char*, Camera> cameras[] = {{"colmap", from_colmap()},
                                                    {"transforms", from_transforms()},
                                                    {"opensfm", from_opensfm()},
                                                    {"openmvg", from_openmvg()},
                                                    {"trajectory", from_trajectory()}};
  for (const auto& [name, camera] : cameras) {
    ASSERT_EQ(camera.width, 280) << name;
    ASSERT_EQ(camera.height, 200) << name;
    glm::dvec2 sum(0.0);
    int count = 0;
    for (const auto& [object, middle] : middles(image_of(camera, targets, 0.08))) {
      const glm::dvec3 seen = w.rotation * (targets[object] - w.center);
      const glm::dvec2 expected(k_focal * seen.x / seen.z + k_cx, k_focal * seen.y / seen.z + k_cy);
      const bool alone = std::ranges::none_of(targets, [&](const glm::dvec3& other) {
        const glm::dvec3 beside = w.rotation * (other - w.center);
        return other != targets[object] && glm::length(glm::dvec2(k_focal * beside.x / beside.z + k_cx,
                                                                  k_focal * beside.y / beside.z + k_cy) -
                                                       expected) < 12.0;
      });
      if (!alone) continue;
      ++count;
      sum += middle - expected;
      EXPECT_LT(glm::length(middle - expected), 0.35) << name;
    }
    ASSERT_GE(count, 10) << name;
    // Half a pixel would show in the mean of all.
    EXPECT_LT(glm::length(sum / static_cast<double>(count)), 0.1) << name;
  }
}

TEST(CameraTargets, columns_of_a_panorama_are_azimuths) {
  std::vector<glm::dvec3> targets;
  for (int step = 0; step < 12; ++step) {
    const double azimuth = (15.0 + 30.0 * step) * std::numbers::pi / 180.0;
    targets.push_back(glm::dvec3(690000, 5325000, 500) +
                      10.0 * glm::dvec3(std::sin(azimuth), std::cos(azimuth), 0.25 * (step % 3)));
  }
  const Camera camera = panorama_camera({690000, 5325000, 500}, 720, 360);
  const auto found = middles(image_of(camera, targets, 0.2));
  EXPECT_EQ(found.size(), 12u);
  for (const auto& [step, middle] : found) {
    const double azimuth = 15.0 + 30.0 * static_cast<double>(step);
    const double column = 720.0 * (azimuth <= 180.0 ? azimuth / 360.0 + 0.5 : azimuth / 360.0 - 0.5);
    const double elevation = std::atan(0.25 * static_cast<double>(step % 3)) * 180.0 / std::numbers::pi;
    EXPECT_NEAR(middle.x, column, 0.15) << azimuth;
    EXPECT_NEAR(middle.y, 2.0 * (90.0 - elevation), 0.35) << azimuth;
  }
}

TEST(CameraTargets, an_orthophoto_shows_everything_at_its_position_whatever_its_height) {
  const Bounds bounds{{690000.03, 5325000.02, 400.0}, {690020.01, 5325010.07, 450.0}};
  const Camera camera = orthophoto_camera(bounds, 0.1);
  EXPECT_EQ(camera.width, 201);
  EXPECT_EQ(camera.height, 101);
  std::vector<glm::dvec3> targets;
  for (int i = 0; i < 12; ++i) targets.emplace_back(690001.5 + 1.5 * i, 5325001.0 + 0.7 * i, 400.0 + 4.0 * i);
  const auto found = middles(image_of(camera, targets, 0.35));
  EXPECT_EQ(found.size(), 12u);
  for (const auto& [object, middle] : found) {
    EXPECT_NEAR(690000.0 + 0.1 * middle.x, targets[object].x, 0.02);
    EXPECT_NEAR(5325010.1 - 0.1 * middle.y, targets[object].y, 0.02);
  }
}

TEST(CameraTargets, an_orthophoto_without_extent_on_the_border_of_pixels_is_the_pixel_north_east_of_it) {
  const Camera camera = orthophoto_camera({{10, 20, 1}, {10, 20, 1}}, 5.0);
  EXPECT_EQ(camera.width, 1);
  EXPECT_EQ(camera.height, 1);
  EXPECT_EQ(camera.pose.position, glm::dvec3(10, 25, 6)) << "of the upper left corner";
}

TEST(CameraTargets, orthophotos_without_extent_or_beyond_all_pixels_are_errors) {
  const Bounds bounds{{0, 0, 0}, {10, 10, 1}};
  EXPECT_THROW(orthophoto_camera({}, 0.1), Error);
  EXPECT_THROW(orthophoto_camera(bounds, 0.0), Error);
  EXPECT_THROW(orthophoto_camera(bounds, NAN), Error);
  EXPECT_THROW(orthophoto_camera(bounds, 1e-4), Error);
  EXPECT_THROW(orthophoto_camera(bounds, 1e-300), Error);
  EXPECT_EQ(orthophoto_camera({{1, 1, 1}, {1, 1, 1}}, 5.0).width, 1);
}

}  // namespace
}  // namespace alidade::test
