// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/matrix.hpp>
#include <map>
#include <numbers>

#include "camera/camera.h"
#include "camera/camera_json.h"
#include "camera/formats/camera_file.h"

namespace alidade::camera {
namespace {

constexpr std::uint64_t k_undefined = UINT32_MAX;
/// Set in an id where a type or an object is written for the first time.
constexpr std::uint64_t k_new = std::uint64_t{1} << 31;

std::uint64_t id_of(const JsonNode& node) {
  return node.whole_number(0, UINT32_MAX);
}

/// The list of key and value pairs under `key`; empty if there is none.
std::vector<JsonNode> entries(const JsonNode& top, std::string_view key) {
  const auto list = top.find(key);
  return list ? list->elements(0, std::size_t(-1)) : std::vector<JsonNode>();
}

/// Resolves the pointers of openMVG's writer: it writes an object where it first occurs, later only its id.
class Pointers {
 public:
  JsonNode object(const JsonNode& value) {
    const JsonNode pointer = required(value, "ptr_wrapper");
    const std::uint64_t id = id_of(required(pointer, "id"));
    if (const auto data = pointer.find("data")) {
      objects_.insert_or_assign(id & ~k_new, *data);
      return *data;
    }
    const auto known = objects_.find(id & ~k_new);
    if (known == objects_.end()) pointer.fail("unknown object", "\"data\", or an id defined above");
    return known->second;
  }

  std::string type(const JsonNode& value) {
    const JsonNode node = required(value, "polymorphic_id");
    const std::uint64_t id = id_of(node);
    if (const auto name = value.find("polymorphic_name")) {
      names_.insert_or_assign(id & ~k_new, name->text());
      return name->text();
    }
    const auto known = names_.find(id & ~k_new);
    if (known == names_.end()) node.fail("unknown type", "\"polymorphic_name\", or an id defined above");
    return known->second;
  }

 private:
  std::map<std::uint64_t, JsonNode> objects_;
  std::map<std::uint64_t, std::string> names_;
};

/// A field of an object, which some types have in the sub-object "value0".
JsonNode base_field(const JsonNode& data, std::string_view key) {
  if (const auto value = data.find(key)) return *value;
  const auto base = data.find("value0");
  return required(base ? *base : data, key);
}

std::vector<double> coefficients(const JsonNode& data, std::string_view key, std::size_t count) {
  std::vector<double> all;
  for (const JsonNode& each : required(data, key).elements(count, count))
    all.push_back(each.number(k_coefficient));
  return all;
}

constexpr std::array<std::string_view, 6> k_types{
    "pinhole", "pinhole_radial_k1", "pinhole_radial_k3", "pinhole_brown_t2", "fisheye", "spherical"};

Lens lens_of(std::string_view type, const JsonNode& data) {
  if (type == "pinhole_radial_k1") return BrownLens{{.radial = {coefficients(data, "disto_k1", 1)[0]}}};
  if (type == "pinhole_radial_k3") {
    const auto k = coefficients(data, "disto_k3", 3);
    return BrownLens{{.radial = {k[0], k[1], k[2]}}};
  }
  if (type == "pinhole_brown_t2") {
    const auto k = coefficients(data, "disto_t2", 5);
    return BrownLens{{.radial = {k[0], k[1], k[2]}, .p1 = k[3], .p2 = k[4]}};
  }
  if (type == "fisheye") {
    const auto k = coefficients(data, "fisheye", 4);
    return FisheyeLens{{.radial = {k[0], k[1], k[2], k[3]}}};
  }
  if (type == "spherical") return EquirectangularLens{};
  return PinholeLens{};
}

Camera read_intrinsics(const std::string& type, const JsonNode& value, const JsonNode& data) {
  if (std::ranges::find(k_types, type) == k_types.end())
    value.fail("unsupported camera type",
               "pinhole, pinhole_radial_k1, pinhole_radial_k3, pinhole_brown_t2, fisheye or spherical",
               type.substr(0, 40));
  Camera camera;
  set_size(camera, base_field(data, "width").whole_number(1, k_max_image_side),
           base_field(data, "height").whole_number(1, k_max_image_side));
  camera.lens = lens_of(type, data);
  if (std::holds_alternative<EquirectangularLens>(camera.lens)) {
    camera.fx = camera.fy = std::max(camera.width, camera.height) / (2.0 * std::numbers::pi);
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
  } else {
    camera.fx = camera.fy = base_field(data, "focal_length").number({0.0, 1e12, true});
    const std::vector<JsonNode> center = base_field(data, "principal_point").elements(2, 2);
    camera.cx = center[0].number({-1e9, 1e9});
    camera.cy = center[1].number({-1e9, 1e9});
  }
  // In openMVG the centres of pixels are whole numbers.
  camera.cx += 0.5;
  camera.cy += 0.5;
  check_camera_numbers(camera);
  return camera;
}

CameraPose pose_of(const JsonNode& value) {
  const JsonNode node = required(value, "rotation");
  const std::vector<JsonNode> rows = node.elements(3, 3);
  glm::dmat3 rotation;
  for (int row = 0; row < 3; ++row) {
    const glm::dvec3 numbers = rows[static_cast<std::size_t>(row)].vector({-2.0, 2.0});
    for (int column = 0; column < 3; ++column) rotation[column][row] = numbers[column];
  }
  if (!(error_of_rotation(rotation) <= k_file_rotation_tolerance) || glm::determinant(rotation) < 0.0)
    node.fail("invalid rotation", "three orthonormal rows, right-handed", "");
  const glm::dmat3 axes = glm::transpose(orthonormal(rotation));
  return {.position = required(value, "center").vector(k_coordinate),
          .right = axes[0],
          .down = axes[1],
          .forward = axes[2]};
}

}  // namespace

CameraSet read_openmvg(const JsonNode& top) {
  Pointers pointers;
  std::map<std::uint64_t, Camera> cameras;
  std::map<std::uint64_t, CameraPose> poses;
  // The writer numbers its pointers through views, intrinsics and extrinsics in this order.
  struct View {
    JsonNode node;
    std::string name;
    std::uint64_t camera, pose;
  };
  std::vector<View> views;
  for (const JsonNode& entry : entries(top, "views")) {
    JsonNode data = pointers.object(required(entry, "value"));
    if (!data.find("filename") && data.find("value0")) data = *data.find("value0");
    std::string name = required(data, "filename").text();
    if (const auto folder = data.find("local_path")) {
      const auto* text = std::get_if<std::string>(&folder->value().data);
      if (text != nullptr && !text->empty())
        name = (std::filesystem::path(folder->text()) / name).generic_string();
    }
    views.push_back({data, name, id_of(required(data, "id_intrinsic")), id_of(required(data, "id_pose"))});
  }
  for (const JsonNode& entry : entries(top, "intrinsics")) {
    const JsonNode value = required(entry, "value");
    const std::string type = pointers.type(value);
    const JsonNode data = pointers.object(value);
    cameras.insert_or_assign(id_of(required(entry, "key")),
                             at_node(value, [&] { return read_intrinsics(type, value, data); }));
  }
  for (const JsonNode& entry : entries(top, "extrinsics"))
    poses.insert_or_assign(id_of(required(entry, "key")), pose_of(required(entry, "value")));

  CameraSet set;
  std::size_t without_pose = 0;
  for (const View& view : views) {
    const auto pose = poses.find(view.pose);
    if (pose == poses.end() || view.camera == k_undefined) {
      ++without_pose;
      continue;
    }
    const auto camera = cameras.find(view.camera);
    if (camera == cameras.end())
      view.node.fail("unknown intrinsic", "a key of \"intrinsics\" as \"id_intrinsic\"",
                     std::to_string(view.camera));
    NamedCamera& named = set.cameras.emplace_back(NamedCamera{view.name, camera->second});
    named.camera.pose = pose->second;
  }
  if (without_pose > 0) set.warnings.push_back(fmt::format("skipped {} views without a pose", without_pose));
  return set;
}

}  // namespace alidade::camera
