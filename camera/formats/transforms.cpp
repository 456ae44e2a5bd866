// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <map>
#include <numbers>
#include <set>

#include "base/exact_math.h"
#include "base/ray.h"
#include "camera/camera.h"
#include "camera/camera_json.h"
#include "camera/formats/camera_file.h"

namespace alidade::camera {
namespace {

constexpr NumberRange k_pixels{-1e9, 1e9};
constexpr NumberRange k_angle{0.0, std::numbers::pi, true, true};

using Members = std::map<std::string, JsonNode>;

/// Looks keys up in a frame first, then at the top.
class FrameFields {
 public:
  FrameFields(const JsonNode& frame, const Members& top, std::set<std::string>& conflicts)
      : frame_(frame), top_(top), conflicts_(conflicts) {}

  std::optional<JsonNode> find(const std::string& key) const {
    const std::optional<JsonNode> own = frame_.find(key);
    const auto common = top_.find(key);
    if (!own) return common == top_.end() ? std::nullopt : std::optional(common->second);
    if (common != top_.end() && differs(*own, common->second)) conflicts_.insert(key);
    return own;
  }
  double number(const std::string& key, double otherwise) const {
    const auto node = find(key);
    return node ? node->number(k_coefficient) : otherwise;
  }

 private:
  static bool differs(const JsonNode& a, const JsonNode& b) {
    if (a.is_number() && b.is_number()) return a.number() != b.number();
    const auto *text = std::get_if<std::string>(&a.value().data),
               *other = std::get_if<std::string>(&b.value().data);
    return text != nullptr && other != nullptr && *text != *other;
  }

  const JsonNode& frame_;
  const Members& top_;
  std::set<std::string>& conflicts_;
};

double focal_length_of_angle(double extent, double angle) {
  const SineCosine half = sine_cosine(0.5 * angle);
  return 0.5 * extent * half.cosine / half.sine;
}

/// The focal length of one axis: from its fov in degrees, else its length, else its angle in radians.
std::optional<double> focal_length(const FrameFields& fields, char axis, double extent) {
  if (const auto fov = fields.find(fmt::format("{}_fov", axis)))
    return focal_length_of_angle(extent, fov->number({0.0, 180.0, true, true}) * std::numbers::pi / 180.0);
  if (const auto length = fields.find(fmt::format("fl_{}", axis))) return length->number({0.0, 1e12, true});
  if (const auto angle = fields.find(fmt::format("camera_angle_{}", axis)))
    return focal_length_of_angle(extent, angle->number(k_angle));
  return std::nullopt;
}

/// Counts that some programs write as 800.0.
std::uint64_t pixels(const JsonNode& node) {
  return node.whole_number(1, k_max_image_side);
}

/// k1 to k4, p1 and p2.
std::array<double, 6> coefficients(const FrameFields& fields) {
  std::array<double, 6> k{};
  const auto list = fields.find("distortion_params");
  const std::vector<JsonNode> all = list ? list->elements(6, 6) : std::vector<JsonNode>();
  for (std::size_t i = 0; i < k.size(); ++i)
    k[i] = list ? all[i].number(k_coefficient)
                : fields.number(i < 4 ? fmt::format("k{}", i + 1) : fmt::format("p{}", i - 3), 0.0);
  return k;
}

Lens lens_of(const FrameFields& fields, std::vector<std::string>& warnings) {
  constexpr std::array<std::string_view, 8> models{"PINHOLE",         "SIMPLE_PINHOLE", "SIMPLE_RADIAL",
                                                   "RADIAL",          "OPENCV",         "OPENCV_FISHEYE",
                                                   "EQUIRECTANGULAR", "perspective"};
  const auto [k1, k2, k3, k4, p1, p2] = coefficients(fields);
  const auto model = fields.find("camera_model");
  const std::size_t choice = model ? model->choice(models) : models.size() - 1;
  const auto is_fisheye = fields.find("is_fisheye");
  if (choice == 5 || (is_fisheye && is_fisheye->boolean())) return FisheyeLens{{.radial = {k1, k2, k3, k4}}};
  if (choice == 6) return EquirectangularLens{};
  Distortion distortion{.radial = {k1, k2, k3, k4}, .p1 = p1, .p2 = p2};
  if (!model && (k3 != 0.0 || k4 != 0.0)) {
    // Without nerfstudio's "camera_model" these are instant-ngp's slots for fisheyes.
    distortion.radial[2] = distortion.radial[3] = 0.0;
    warnings.emplace_back("ignoring k3 and k4: they require \"camera_model\" or \"is_fisheye\"");
  }
  return BrownLens{distortion};
}

void set_intrinsics(const FrameFields& fields, const JsonNode& frame, const std::filesystem::path& image,
                    Camera& camera) {
  const auto width = fields.find("w"), height = fields.find("h");
  if (width && height) {
    at_node(frame, [&] { set_size(camera, pixels(*width), pixels(*height)); });
  } else {
    at_node(frame, [&] {
      const ImageFileSize size = image_file_size(image);
      set_size(camera, size.width, size.height);
    });
  }
  const double w = camera.width, h = camera.height;
  const auto center_x = fields.find("cx"), center_y = fields.find("cy");
  camera.cx = center_x ? center_x->number(k_pixels) : 0.5 * w;
  camera.cy = center_y ? center_y->number(k_pixels) : 0.5 * h;
  if (std::holds_alternative<EquirectangularLens>(camera.lens)) {
    camera.fx = w / (2.0 * std::numbers::pi);
    camera.fy = h / std::numbers::pi;
    return;
  }
  const auto across = focal_length(fields, 'x', w);
  if (!across) {
    frame.fail("missing focal length", R"("fl_x", "camera_angle_x" or "x_fov", here or at the top)",
               "none of them");
  }
  camera.fx = *across;
  camera.fy = focal_length(fields, 'y', h).value_or(camera.fx);
}

/// Removes a uniform scale from a rotation. Errors: the rest is not a rotation.
double take_scale(const JsonNode& node, glm::dmat3& linear) {
  const double scale = length_of(linear[0]);
  if (scale > 0.0) linear /= scale;
  const double error = error_of_rotation(linear);
  if (!(error <= k_file_rotation_tolerance) || glm::determinant(linear) < 0.0) {
    node.fail("invalid rotation",
              "the first three columns to be orthogonal, of equal length and right-handed",
              error <= k_file_rotation_tolerance ? "a left-handed matrix"
                                                 : fmt::format("a deviation of {:.3g}", error));
  }
  linear = orthonormal(linear);
  return scale;
}

/// From the world of the file to the one before its conversion.
struct WorldChange {
  glm::dmat3 rotation{1.0};
  glm::dvec3 shift{0.0};
  double scale = 1.0;
};

CameraPose before(const WorldChange& change, const CameraPose& pose) {
  const glm::dmat3 back = glm::transpose(change.rotation);
  return {.position = back * (pose.position / change.scale - change.shift),
          .right = back * pose.right,
          .down = back * pose.down,
          .forward = back * pose.forward};
}

std::optional<WorldChange> world_change(const JsonNode& top) {
  const auto transform = top.find("applied_transform"), scale = top.find("applied_scale");
  if (!transform && !scale) return std::nullopt;
  WorldChange change;
  if (transform) {
    Transform affine = read_transform(transform->elements(3, 4));
    change.rotation = affine.rotation;
    change.shift = affine.translation;
    const double length = take_scale(*transform, change.rotation);
    if (std::fabs(length - 1.0) > k_file_rotation_tolerance)
      transform->fail("applied_transform is not rigid", "a rotation and a translation", "a scale");
  }
  if (scale) change.scale = scale->number({1e-9, 1e9});
  return change;
}

}  // namespace

CameraSet read_transforms(const JsonNode& top, const std::filesystem::path& file, bool original_world) {
  CameraSet set;
  std::set<std::string> conflicts;
  std::size_t scaled = 0;
  const std::optional<WorldChange> change = world_change(top);
  Members common;
  for (auto& [key, value] : top.members()) common.emplace(key, value);
  for (const JsonNode& frame : top.find("frames")->elements(0, std::size_t(-1))) {
    const auto path = frame.find("file_path"), matrix = frame.find("transform_matrix");
    if (!path) frame.fail("missing key \"file_path\"", "", "");
    if (!matrix) frame.fail("missing key \"transform_matrix\"", "", "");
    NamedCamera named{path->text(), {}};
    std::ranges::replace(named.name, '\\', '/');
    const FrameFields fields(frame, common, conflicts);
    std::vector<std::string> warnings;
    named.camera.lens = lens_of(fields, warnings);
    if (set.warnings.empty()) set.warnings = warnings;
    set_intrinsics(fields, frame, file.parent_path() / named.name, named.camera);

    Transform affine = read_transform(matrix->elements(3, 4));
    const double scale = take_scale(*matrix, affine.rotation);
    if (std::fabs(scale - 1.0) > k_file_rotation_tolerance) ++scaled;
    named.camera.pose = {.position = affine.translation,
                         .right = affine.rotation[0],
                         .down = -affine.rotation[1],
                         .forward = -affine.rotation[2]};
    if (original_world && change) named.camera.pose = before(*change, named.camera.pose);
    at_node(frame, [&] { check_camera_numbers(named.camera); });
    set.cameras.push_back(std::move(named));
  }
  for (const std::string& key : conflicts)
    set.warnings.push_back(
        fmt::format("\"{}\" differs between the file and its frames; using the value of the frame", key));
  if (scaled > 0) set.warnings.push_back(fmt::format("removed the scale of {} poses", scaled));
  if (change && !original_world)
    set.warnings.emplace_back(
        "the cameras are in a world that applied_transform and applied_scale have transformed");
  return set;
}

}  // namespace alidade::camera
