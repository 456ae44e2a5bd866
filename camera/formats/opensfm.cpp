// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numbers>

#include "camera/camera.h"
#include "camera/camera_json.h"
#include "camera/formats/camera_file.h"

namespace alidade::camera {
namespace {

constexpr NumberRange k_rotation{-1e3, 1e3};

double coefficient(const JsonNode& camera, std::string_view key) {
  const auto node = camera.find(key);
  return node ? node->number(k_coefficient) : 0.0;
}

Distortion radial(const JsonNode& camera, std::size_t count) {
  Distortion distortion;
  for (std::size_t i = 0; i < count; ++i)
    distortion.radial[i] = coefficient(camera, fmt::format("k{}", i + 1));
  return distortion;
}

void add_tangential(const JsonNode& camera, Distortion& distortion) {
  distortion.p1 = coefficient(camera, "p1");
  distortion.p2 = coefficient(camera, "p2");
}

constexpr std::array<std::string_view, 11> k_projections{
    "perspective", "simple_radial", "radial", "brown",     "fisheye",        "fisheye_opencv",
    "fisheye62",   "fisheye624",    "dual",   "spherical", "equirectangular"};

Lens lens_of(const JsonNode& camera, std::string_view projection) {
  if (projection == "perspective" || projection == "radial") return BrownLens{radial(camera, 2)};
  if (projection == "simple_radial") return BrownLens{radial(camera, 1)};
  if (projection == "fisheye") return FisheyeLens{radial(camera, 2)};
  if (projection == "fisheye_opencv") return FisheyeLens{radial(camera, 4)};
  if (projection == "dual")
    return DualLens{required(camera, "transition").number({0.0, 1.0}), radial(camera, 2)};
  if (projection == "brown") {
    BrownLens lens{radial(camera, 3)};
    add_tangential(camera, lens.distortion);
    return lens;
  }
  if (projection == "spherical" || projection == "equirectangular") return EquirectangularLens{};
  FisheyeLens lens{radial(camera, 6)};
  add_tangential(camera, lens.distortion);
  if (projection == "fisheye624") {
    for (std::size_t i = 0; i < 4; ++i) lens.distortion.prism[i] = coefficient(camera, fmt::format("s{}", i));
  }
  return lens;
}

Camera read_camera(const JsonNode& node) {
  std::string_view projection = "perspective";
  if (const auto type = node.find("projection_type")) projection = k_projections[type->choice(k_projections)];
  Camera camera;
  set_size(camera, required(node, "width").whole_number(1, k_max_image_side),
           required(node, "height").whole_number(1, k_max_image_side));
  camera.lens = lens_of(node, projection);
  // Lengths are in units of the longer side, coordinates count from the middle.
  const double unit = std::max(camera.width, camera.height);
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  if (std::holds_alternative<EquirectangularLens>(camera.lens)) {
    camera.fx = camera.fy = unit / (2.0 * std::numbers::pi);
    return camera;
  }
  constexpr NumberRange k_focal{0.0, 1e6, true};
  if (const auto focal = node.find("focal")) {
    camera.fx = camera.fy = focal->number(k_focal) * unit;
  } else {
    camera.fx = required(node, "focal_x").number(k_focal) * unit;
    camera.fy = required(node, "focal_y").number(k_focal) * unit;
    camera.cx += coefficient(node, "c_x") * unit;
    camera.cy += coefficient(node, "c_y") * unit;
  }
  check_camera_numbers(camera);
  return camera;
}

}  // namespace

CameraSet read_opensfm(const JsonNode& top) {
  CameraSet set;
  const std::vector<JsonNode> reconstructions = top.elements(1, std::size_t(-1));
  const JsonNode& first = reconstructions.front();
  if (reconstructions.size() > 1) {
    set.warnings.push_back(fmt::format("using only the first of {} reconstructions: each has its own world",
                                       reconstructions.size()));
  }
  std::map<std::string, Camera> cameras;
  for (const auto& [name, node] : required(first, "cameras").members()) {
    const JsonNode& camera = node;
    cameras.emplace(name, at_node(camera, [&] { return read_camera(camera); }));
  }
  for (const auto& [name, shot] : required(first, "shots").members()) {
    const JsonNode id = required(shot, "camera");
    const auto camera = cameras.find(id.text());
    if (camera == cameras.end()) id.fail("unknown camera", "a key of \"cameras\"");
    NamedCamera& named = set.cameras.emplace_back(NamedCamera{name, camera->second});
    named.camera.pose =
        pose_from_world_to_camera(rotation_from_axis_angle(required(shot, "rotation").vector(k_rotation)),
                                  required(shot, "translation").vector(k_coordinate));
  }
  return set;
}

}  // namespace alidade::camera
