// SPDX-License-Identifier: MIT
// Real photographs' cameras: what an image shows at a pixel is, by the formula, at this pixel; and photos
// have there the colour that their reconstruction's points have.
#include <gtest/gtest.h>

#include <OpenImageIO/imagebuf.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "camera/camera.h"
#include "camera/camera_set.h"
#include "camera/projection.h"
#include "cloud/read_cloud.h"
#include "octree/build.h"
#include "renderer/render.h"
#include "tests/support/absent_data.h"
#include "tests/support/point_families.h"

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;

namespace {

using Json = nlohmann::json;

std::filesystem::path shared(const std::string& name) {
  return std::filesystem::path(ALIDADE_SHARED_DATA) / name;
}

Json json_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return Json::parse(stream);
}

struct ColoredPoint {
  glm::dvec3 position;
  glm::dvec3 color;  ///< 0 to 255
};

/// The pinhole formula in full-size pixels, for a point in the camera's axes.
using Formula = std::function<glm::dvec2(const glm::dvec3& world)>;

/// Renders the points as balls small enough to cover about a pixel, and compares every pixel that shows one
/// with the formula.
void expect_points_at_the_formula(const Camera& camera, const std::vector<ColoredPoint>& points,
                                  double shrink, const Formula& formula, std::size_t least_count) {
  std::vector<glm::dvec3> positions;
  for (const ColoredPoint& each : points) positions.push_back(each.position);
  Bounds bounds;
  for (const glm::dvec3& position : positions) bounds.grow(position);
  LoadedCloud cloud;
  cloud.octree = build(make_cloud(positions, {glm::dvec3(1e-6), bounds.center()}));
  cloud.colors.assign(positions.size(), Color16(65535));
  double nearest = INFINITY;
  for (const glm::dvec3& position : positions) {
    const glm::dvec3 offset = position - camera.pose.position;
    if (glm::dot(offset, camera.pose.forward) > 0.0) nearest = std::min(nearest, glm::length(offset));
  }
  Scene scene;
  scene.sky = ConstantSky{Rgb(1.0f)};
  scene.cloud.emplace();
  scene.render.samples = 1;
  scene.render.max_bounces = 0;
  scene.camera =
      resized(camera, static_cast<int>(camera.width * shrink), static_cast<int>(camera.height * shrink));
  cloud.radius = 0.7 * nearest / scene.camera->fx;
  const Film film = render(scene, &cloud);
  std::size_t count = 0;
  double worst = 0.0;
  for (int y = 0; y < film.height; ++y) {
    for (int x = 0; x < film.width; ++x) {
      const std::uint32_t id = film.id[film.index(x, y)];
      if (id == 0) continue;
      ++count;
      worst =
          std::max(worst, glm::length(shrink * formula(positions[id - 1]) - glm::dvec2(x + 0.5, y + 0.5)));
    }
  }
  EXPECT_GE(count, least_count);
  EXPECT_LT(worst, 1.0);
}

/// Median difference of the points' colours and a photo's, read `shift` pixels beside their positions.
double color_difference(const OIIO::ImageBuf& photo, const std::vector<ColoredPoint>& points,
                        const Formula& formula, const glm::dvec2& shift) {
  std::vector<double> differences;
  for (const ColoredPoint& each : points) {
    const glm::dvec2 film = formula(each.position) + shift;
    if (!(film.x >= 0.0 && film.y >= 0.0 && film.x < photo.spec().width && film.y < photo.spec().height))
      continue;
    float pixel[3];
    photo.getpixel(static_cast<int>(film.x), static_cast<int>(film.y), pixel, 3);
    differences.push_back(glm::length(255.0 * glm::dvec3(pixel[0], pixel[1], pixel[2]) - each.color));
  }
  if (differences.empty()) return INFINITY;
  std::nth_element(differences.begin(),
                   differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2),
                   differences.end());
  return differences[differences.size() / 2];
}

void expect_colors_of_photo(const std::filesystem::path& file, const std::vector<ColoredPoint>& points,
                            const Formula& formula) {
  const OIIO::ImageBuf photo(file.string());
  const double here = color_difference(photo, points, formula, {0.0, 0.0});
  for (const glm::dvec2& shift :
       {glm::dvec2(60, 0), glm::dvec2(-60, 0), glm::dvec2(0, 60), glm::dvec2(0, -60)})
    EXPECT_LT(here, 0.75 * color_difference(photo, points, formula, shift)) << shift.x << " " << shift.y;
}

TEST(RealScenes, points_of_sceaux_are_where_the_formula_puts_them) {
  if (!std::filesystem::exists(shared("scene_sceaux"))) GTEST_SKIP() << absent("../shared/data/scene_sceaux");
  const PointCloud cloud = read_cloud(shared("scene_sceaux/Sparse.ply"));
  std::vector<ColoredPoint> points;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    points.push_back({cloud.world(i), glm::dvec3(cloud.colors[i]) / 257.0});
  const Json file = json_of(shared("scene_sceaux/cameras.json"));
  for (const Json& each : file.at("cameras")) {
    if (each.at("image") != "00004.jpg") continue;
    glm::dmat3 rotation;
    glm::dvec3 center;
    for (int row = 0; row < 3; ++row) {
      center[row] = each.at("camera_centre_world").at(row);
      for (int column = 0; column < 3; ++column)
        rotation[column][row] = each.at("R_world_to_camera").at(row).at(column);
    }
    const double fx = each.at("fx"), fy = each.at("fy"), cx = each.at("cx"), cy = each.at("cy");
    const Camera camera{.width = each.at("width"),
                        .height = each.at("height"),
                        .fx = fx,
                        .fy = fy,
                        .cx = cx,
                        .cy = cy,
                        .pose = pose_from_world_to_camera(rotation, -(rotation * center))};
    const Formula formula = [&](const glm::dvec3& world) {
      const glm::dvec3 seen = rotation * (world - center);
      return seen.z > 0.0 ? glm::dvec2(fx * seen.x / seen.z + cx, fy * seen.y / seen.z + cy)
                          : glm::dvec2(-1e9);
    };
    expect_points_at_the_formula(camera, points, 0.5, formula, 500);
    expect_colors_of_photo(shared("scene_sceaux/00004.jpg"), points, formula);
  }
}

TEST(RealScenes, points_of_berlin_are_where_the_formula_puts_them) {
  const std::filesystem::path file = shared("scene_berlin/reconstruction_example.json");
  if (!std::filesystem::exists(file)) GTEST_SKIP() << absent("../shared/data/scene_berlin");
  const Json reconstruction = json_of(file).at(0);
  std::vector<ColoredPoint> points;
  const auto vector = [](const Json& numbers) {
    return glm::dvec3(numbers.at(0), numbers.at(1), numbers.at(2));
  };
  for (const Json& point : reconstruction.at("points"))
    points.push_back({vector(point.at("coordinates")), vector(point.at("color"))});
  const CameraSet set = read_cameras(file);
  ASSERT_EQ(set.cameras.size(), 3u);
  for (const NamedCamera& each : set.cameras) {
    const Json& shot = reconstruction.at("shots").at(each.name);
    const Json& lens = reconstruction.at("cameras").at(shot.at("camera").get<std::string>());
    const glm::dvec3 turn = vector(shot.at("rotation")), shift = vector(shot.at("translation"));
    const double k1 = lens.at("k1"), k2 = lens.at("k2"), focal = lens.at("focal"), width = lens.at("width"),
                 height = lens.at("height");
    const Formula formula = [&](const glm::dvec3& world) {
      // Rodrigues' formula on the point itself.
      const double angle = glm::length(turn);
      const glm::dvec3 axis = turn / angle;
      const glm::dvec3 seen = world * std::cos(angle) + glm::cross(axis, world) * std::sin(angle) +
                              axis * glm::dot(axis, world) * (1.0 - std::cos(angle)) + shift;
      if (!(seen.z > 0.0)) return glm::dvec2(-1e9);
      const glm::dvec2 flat(seen.x / seen.z, seen.y / seen.z);
      const double r2 = glm::dot(flat, flat);
      return flat * (1.0 + k1 * r2 + k2 * r2 * r2) * focal * width + glm::dvec2(0.5 * width, 0.5 * height);
    };
    expect_points_at_the_formula(each.camera, points, 0.5, formula, 200);
    expect_colors_of_photo(shared("scene_berlin/" + each.name), points, formula);
  }
}

}  // namespace
}  // namespace alidade::test
