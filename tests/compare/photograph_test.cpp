// SPDX-License-Identifier: MIT
// A real photograph beside the render of the scan from its camera: the pose is right, the colours nearly.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "camera/camera.h"
#include "compare/photographs/alignment.h"
#include "compare/photographs/color_match.h"
#include "compare/read_compared_image.h"
#include "renderer/render.h"
#include "tests/support/absent_data.h"

namespace alidade::test {

using namespace image;
using namespace camera;
using namespace renderer;
using namespace compare;

namespace {

std::filesystem::path shared(const std::string& name) {
  return std::filesystem::path(ALIDADE_SHARED_DATA) / "scene_sceaux" / name;
}

/// The camera of the photo 00004.jpg, for images of half its size.
Camera photo_camera() {
  std::ifstream stream(shared("cameras.json"));
  const nlohmann::json file = nlohmann::json::parse(stream);
  for (const nlohmann::json& each : file.at("cameras")) {
    if (each.at("image") != "00004.jpg") continue;
    glm::dmat3 rotation;
    glm::dvec3 center;
    for (int row = 0; row < 3; ++row) {
      center[row] = each.at("camera_centre_world").at(row);
      for (int column = 0; column < 3; ++column)
        rotation[column][row] = each.at("R_world_to_camera").at(row).at(column);
    }
    const Camera camera{.width = each.at("width"),
                        .height = each.at("height"),
                        .fx = each.at("fx"),
                        .fy = each.at("fy"),
                        .cx = each.at("cx"),
                        .cy = each.at("cy"),
                        .pose = pose_from_world_to_camera(rotation, -(rotation * center))};
    return resized(camera, camera.width / 2, camera.height / 2);
  }
  throw Error({.problem = "no camera of that name"});
}

/// The scan in its own colours, without light.
ComparedImage seen(const LoadedCloud& cloud, const Camera& camera, PointShape shape = PointShape::sphere) {
  Scene scene;
  scene.cloud.emplace().shape = shape;
  scene.render.mode = RenderMode::flat;
  scene.render.samples = 1;
  scene.camera = camera;
  const Film film = render(scene, &cloud);
  ComparedImage image;
  image.width = film.width;
  image.height = film.height;
  image.encoding = ColorEncoding::linear;
  image.color_channels = 3;
  for (const Rgb& color : film.color) image.color.insert(image.color.end(), {color[0], color[1], color[2]});
  image.depth = film.depth;
  return image;
}

/// Root mean square difference of display values where the scan has points.
double difference(const ComparedImage& photo, const ComparedImage& test) {
  const std::vector<float> one = display_color(photo), other = display_color(test);
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (!std::isfinite(test.depth[i / 3])) continue;
    sum += std::pow(static_cast<double>(one[i] - other[i]), 2.0);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

/// The photo, and what its camera sees of the scan.
struct Pair {
  Camera camera = photo_camera();
  ComparedImage photo = resized(read_compared_image(shared("00004.jpg")), camera.width, camera.height);
  LoadedCloud cloud = load_cloud(scan_settings());
  ComparedImage render = seen(cloud, camera);

  static CloudSettings scan_settings() {
    CloudSettings settings;
    settings.files = {shared("sceaux_colored.ply")};
    return settings;
  }
};

const Pair& pair() {
  static const Pair pair;
  return pair;
}

class Photograph : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(shared("00004.jpg"))) GTEST_SKIP() << absent("../shared/data/scene_sceaux");
  }
};

TEST_F(Photograph, render_from_its_camera_is_aligned_and_the_shift_of_the_same_render_is_reported) {
  const Alignment alignment = align(pair().photo, pair().render, {});
  EXPECT_TRUE(alignment.is_certain);
  // Below two pixels of the photo.
  EXPECT_LT(std::hypot(alignment.shift_x, alignment.shift_y), 1.0);
  EXPECT_GT(alignment.score, 0.4);
  for (const auto& [x, y] : {std::pair(5.0, 0.0), std::pair(-38.0, 21.0)}) {
    Camera moved = pair().camera;
    moved.cx += x;
    moved.cy += y;
    const Alignment shifted = align(pair().photo, seen(pair().cloud, moved), {});
    EXPECT_TRUE(shifted.is_certain);
    EXPECT_NEAR(shifted.shift_x, alignment.shift_x + x, 0.1);
    EXPECT_NEAR(shifted.shift_y, alignment.shift_y + y, 0.1);
    EXPECT_LT(shifted.score_unshifted, 0.5 * shifted.score);
  }
}

TEST_F(Photograph, discs_are_where_the_photograph_has_them_and_spheres_are_not) {
  CloudSettings settings = Pair::scan_settings();
  settings.shape = PointShape::blend;
  const LoadedCloud cloud = load_cloud(settings);
  const Alignment of_discs = align(pair().photo, seen(cloud, pair().camera, PointShape::blend), {});
  const Alignment of_spheres = align(pair().photo, pair().render, {});
  EXPECT_TRUE(of_discs.is_certain);
  EXPECT_LT(std::hypot(of_discs.shift_x, of_discs.shift_y), 0.15);
  EXPECT_LT(4.0 * std::hypot(of_discs.shift_x, of_discs.shift_y),
            std::hypot(of_spheres.shift_x, of_spheres.shift_y));
  EXPECT_GT(of_discs.score, of_spheres.score);
}

TEST_F(Photograph, matched_colours_are_nearer_and_a_render_of_other_exposure_is_brought_back) {
  for (const ColorModel model : {ColorModel::exposure, ColorModel::affine}) {
    const std::optional<ColorMatch> match = match_color(pair().photo, pair().render, {}, model);
    ASSERT_TRUE(match);
    ComparedImage matched = pair().render;
    apply_color_match(matched, *match);
    const double before = difference(pair().photo, pair().render), after = difference(pair().photo, matched);
    RecordProperty("before", std::to_string(before));
    RecordProperty("after", std::to_string(after));
    EXPECT_LT(after, before);

    ComparedImage darker = pair().render;
    apply_color_match(darker, {.scale = {0.2, 0.25, 0.3}});
    EXPECT_GT(difference(pair().photo, darker), 2.0 * before);
    const std::optional<ColorMatch> brighter = match_color(pair().photo, darker, {}, model);
    ASSERT_TRUE(brighter);
    apply_color_match(darker, *brighter);
    EXPECT_NEAR(difference(pair().photo, darker), after, 0.02 * after);
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(brighter->scale[channel] * (0.2 + 0.05 * channel), match->scale[channel],
                  0.05 * match->scale[channel]);
  }
}

}  // namespace
}  // namespace alidade::test
