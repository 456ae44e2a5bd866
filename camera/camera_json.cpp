// SPDX-License-Identifier: MIT
#include "camera/camera_json.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/matrix.hpp>
#include <numbers>

#include "base/input_file.h"
#include "camera/projection.h"

namespace alidade::camera {
namespace {

/// "key": value, for values that are not the default 0.
class Fields {
 public:
  void add(std::string_view key, double value) {
    if (value != 0.0) require(key, value);
  }
  void require(std::string_view key, double value) {
    text_ += fmt::format("{}\"{}\": {:.17g}", text_.empty() ? "" : ", ", key, value);
  }
  void add_word(std::string_view key, std::string_view word) {
    text_ += fmt::format("{}\"{}\": \"{}\"", text_.empty() ? "" : ", ", key, word);
  }
  std::string object() const { return "{" + text_ + "}"; }

 private:
  std::string text_;
};

void add_bend(const Distortion& distortion, Fields& fields) {
  fields.add("p1", distortion.p1);
  fields.add("p2", distortion.p2);
  for (std::size_t i = 0; i < distortion.prism.size(); ++i)
    fields.add(fmt::format("s{}", i + 1), distortion.prism[i]);
}

struct DistortionObject {
  std::string operator()(const PinholeLens&) const { return ""; }
  std::string operator()(const OrthographicLens&) const { return ""; }
  std::string operator()(const EquirectangularLens&) const { return ""; }
  std::string operator()(const BrownLens& lens) const {
    Fields fields;
    const Distortion& distortion = lens.distortion;
    for (std::size_t i = 0; i < 3; ++i) fields.add(fmt::format("k{}", i + 1), distortion.radial[i]);
    for (std::size_t i = 0; i < 3; ++i) fields.add(fmt::format("k{}", i + 4), distortion.denominator[i]);
    fields.add("r8", distortion.radial[3]);
    add_bend(distortion, fields);
    return fields.object();
  }
  std::string operator()(const FisheyeLens& lens) const {
    Fields fields;
    const Distortion& distortion = lens.distortion;
    for (std::size_t i = 0; i < 6; ++i) fields.add(fmt::format("k{}", i + 1), distortion.radial[i]);
    add_bend(distortion, fields);
    if (distortion.after_radial) fields.add_word("order", "radial_first");
    return fields.object();
  }
  std::string operator()(const FieldOfViewLens& lens) const { return one("omega", lens.omega); }
  std::string operator()(const DivisionLens& lens) const { return one("k", lens.k); }
  std::string operator()(const UnifiedLens& lens) const {
    Fields fields;
    fields.require("alpha", lens.alpha);
    fields.require("beta", lens.beta);
    return fields.object();
  }
  std::string operator()(const DualLens& lens) const {
    Fields fields;
    fields.require("transition", lens.transition);
    fields.add("k1", lens.distortion.radial[0]);
    fields.add("k2", lens.distortion.radial[1]);
    return fields.object();
  }
  static std::string one(std::string_view key, double value) {
    Fields fields;
    fields.require(key, value);
    return fields.object();
  }
};

// Views outside this range are mistakes; within it focal lengths are ordinary numbers.
constexpr NumberRange k_field_of_view{1e-6, 179.999};
constexpr NumberRange k_focal_length{1e-6, 1e12};
constexpr NumberRange k_principal_point{-1e9, 1e9};
constexpr NumberRange k_resolution{1e-9, 1e6};

template <typename Each>
bool is_model(std::size_t model) {
  return Lens(Each{}).index() == model;
}

double coefficient(const JsonFields& fields, std::string_view key) {
  const auto node = fields.find(key);
  return node ? node->number(k_coefficient) : 0.0;
}

void read_focal_lengths(const JsonFields& fields, Camera& camera) {
  camera.fx = fields.require("fx").number(k_focal_length);
  camera.fy = fields.require("fy").number(k_focal_length);
  camera.cx = fields.require("cx").number(k_principal_point);
  camera.cy = fields.require("cy").number(k_principal_point);
}

void center(Camera& camera, double fx, double fy) {
  camera.fx = fx;
  camera.fy = fy;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
}

bool has_focal_length(const JsonFields& fields) {
  return fields.find("fx") || fields.find("fy") || fields.find("cx") || fields.find("cy");
}

void read_perspective(const JsonNode& node, Camera& camera) {
  const JsonFields fields(node, {"vertical_fov", "horizontal_fov", "fx", "fy", "cx", "cy"});
  if (const auto fov = fields.find("vertical_fov")) {
    const JsonFields alone(node, {"vertical_fov"});
    camera = pinhole_from_fov(camera.width, camera.height, fov->number(k_field_of_view), camera.pose);
  } else if (const auto across = fields.find("horizontal_fov")) {
    const JsonFields alone(node, {"horizontal_fov"});
    // The camera turned on its side, which has this field of view vertically.
    const Camera turned =
        pinhole_from_fov(camera.height, camera.width, across->number(k_field_of_view), camera.pose);
    center(camera, turned.fx, turned.fy);
  } else if (has_focal_length(fields)) {
    read_focal_lengths(fields, camera);
  } else {
    node.fail("missing focal length", R"("vertical_fov", "horizontal_fov" or "fx", "fy", "cx", "cy")",
              "none of them");
  }
}

void read_orthographic(const JsonNode& node, Camera& camera) {
  const JsonFields fields(node, {"resolution", "fx", "fy", "cx", "cy"});
  if (const auto resolution = fields.find("resolution")) {
    const JsonFields alone(node, {"resolution"});
    const double pixels = 1.0 / resolution->number(k_resolution);
    center(camera, pixels, pixels);
  } else {
    read_focal_lengths(fields, camera);
  }
}

void read_equirectangular(const JsonNode& node, Camera& camera) {
  const JsonFields fields(node, {"horizontal_fov", "vertical_fov", "fx", "fy", "cx", "cy"});
  if (has_focal_length(fields)) {
    const JsonFields alone(node, {"fx", "fy", "cx", "cy"});
    read_focal_lengths(fields, camera);
    return;
  }
  double across = 360.0, upright = 180.0;
  if (const auto fov = fields.find("horizontal_fov")) across = fov->number({1e-6, 360.0});
  if (const auto fov = fields.find("vertical_fov")) upright = fov->number({1e-6, 180.0});
  constexpr double k_degree = std::numbers::pi / 180.0;
  center(camera, camera.width / (across * k_degree), camera.height / (upright * k_degree));
}

BrownLens read_brown(const JsonNode& node) {
  const JsonFields fields(node,
                          {"k1", "k2", "k3", "k4", "k5", "k6", "r8", "p1", "p2", "s1", "s2", "s3", "s4"});
  const auto value = [&](std::string_view key) { return coefficient(fields, key); };
  return {{.radial = {value("k1"), value("k2"), value("k3"), value("r8")},
           .denominator = {value("k4"), value("k5"), value("k6")},
           .p1 = value("p1"),
           .p2 = value("p2"),
           .prism = {value("s1"), value("s2"), value("s3"), value("s4")}}};
}

FisheyeLens read_fisheye(const JsonNode& node) {
  const JsonFields fields(node,
                          {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "s1", "s2", "s3", "s4", "order"});
  const auto value = [&](std::string_view key) { return coefficient(fields, key); };
  FisheyeLens lens{{.radial = {value("k1"), value("k2"), value("k3"), value("k4"), value("k5"), value("k6")},
                    .p1 = value("p1"),
                    .p2 = value("p2"),
                    .prism = {value("s1"), value("s2"), value("s3"), value("s4")}}};
  if (const auto order = fields.find("order")) {
    constexpr std::array<std::string_view, 2> words{"together", "radial_first"};
    lens.distortion.after_radial = order->choice(words) == 1;
  }
  return lens;
}

UnifiedLens read_unified(const JsonNode& node) {
  const JsonFields fields(node, {"alpha", "beta"});
  return {.alpha = fields.require("alpha").number({0.0, 1.0}),
          .beta = fields.require("beta").number({0.0, 1e6, true})};
}

DualLens read_dual(const JsonNode& node) {
  const JsonFields fields(node, {"transition", "k1", "k2"});
  return {.transition = fields.require("transition").number({0.0, 1.0}),
          .distortion = {.radial = {coefficient(fields, "k1"), coefficient(fields, "k2")}}};
}

/// The index of a camera's "model" in k_lens_names.
std::size_t model_of(const JsonNode& camera) {
  if (const auto model = camera.find("model")) return model->choice(k_lens_names);
  const JsonFields fields(
      camera, {"version", "description", "model", "width", "height", "intrinsics", "distortion", "pose"});
  return fields.require("model").choice(k_lens_names);
}

/// Reads "intrinsics" of a camera of that model: sets its focal lengths, principal point and, without
/// distortion, lens. Requires its size.
void read_intrinsics(const JsonNode& node, std::size_t model, Camera& camera) {
  if (is_model<PinholeLens>(model) || is_model<BrownLens>(model)) {
    read_perspective(node, camera);
  } else if (is_model<OrthographicLens>(model)) {
    read_orthographic(node, camera);
    camera.lens = OrthographicLens{};
  } else if (is_model<EquirectangularLens>(model)) {
    read_equirectangular(node, camera);
    camera.lens = EquirectangularLens{};
  } else {
    read_focal_lengths(JsonFields(node, {"fx", "fy", "cx", "cy"}), camera);
  }
}

/// Reads "distortion" of a camera of a distorting model.
Lens read_distortion(const JsonNode& node, std::size_t model) {
  if (is_model<BrownLens>(model)) return read_brown(node);
  if (is_model<FisheyeLens>(model)) return read_fisheye(node);
  if (is_model<UnifiedLens>(model)) return read_unified(node);
  if (is_model<DualLens>(model)) return read_dual(node);
  if (is_model<FieldOfViewLens>(model))
    return FieldOfViewLens{JsonFields(node, {"omega"}).require("omega").number({-3.14159, 3.14159})};
  return DivisionLens{JsonFields(node, {"k"}).require("k").number(k_coefficient)};
}

constexpr double k_rotation_tolerance = 1e-6;
// Below this a rotation has the precision of double and is kept bit for bit, so that one written with 17
// digits is read back unchanged.
constexpr double k_exact_rotation = 1e-12;

// Files often have few digits, but the axes of rays must be orthonormal.
glm::dmat3 checked_rotation(const JsonNode& node, const glm::dmat3& rotation) {
  const double error = error_of_rotation(rotation);
  if (!(error <= k_rotation_tolerance)) {
    node.fail("the rotation is not orthonormal", "orthonormal columns, to 1e-6",
              "an error of " + std::to_string(error));
  }
  if (glm::determinant(rotation) < 0.0)
    node.fail("the rotation is a reflection", "determinant +1", "determinant -1");
  if (error <= k_exact_rotation) return rotation;
  return orthonormal(rotation);
}

glm::dmat3 read_quaternion(const JsonNode& node) {
  const std::vector<JsonNode> numbers = node.elements(4, 4);
  std::array<double, 4> q{};
  for (std::size_t i = 0; i < 4; ++i) q[i] = numbers[i].number({-2, 2});
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (std::fabs(length - 1.0) > k_rotation_tolerance) {
    node.fail("the quaternion is not normalized", "w, x, y, z of length 1, to 1e-6",
              "length " + std::to_string(length));
  }
  return *rotation_from_quaternion(q);
}

Transform transform_from_matrix(const JsonNode& node) {
  const std::vector<JsonNode> rows = node.elements(4, 4);
  Transform transform = read_transform(rows);
  const std::vector<JsonNode> last = rows[3].elements(4, 4);
  for (std::size_t column = 0; column < 4; ++column) {
    const double value = last[column].number(k_coordinate);
    if (value != (column == 3 ? 1.0 : 0.0)) {
      rows[3].fail("the transform is not rigid", "the last row 0, 0, 0, 1 (transpose a column-major matrix)",
                   fmt::format("{} in column {}", value, column));
    }
  }
  transform.rotation = checked_rotation(node, transform.rotation);
  return transform;
}

CameraPose pose_from_transform(const JsonFields& fields, Transform transform) {
  constexpr std::array<std::string_view, 2> conventions{"opencv", "opengl"};
  constexpr std::array<std::string_view, 2> directions{"camera_to_world", "world_to_camera"};
  const std::size_t convention = fields.require("convention").choice(conventions);
  if (fields.require("direction").choice(directions) == 1) {
    transform.rotation = glm::transpose(transform.rotation);
    transform.translation = -(transform.rotation * transform.translation);
  }
  const double sign = convention == 0 ? 1.0 : -1.0;  // OpenGL's y points up and its z backward
  return {.position = transform.translation,
          .right = transform.rotation[0],
          .down = sign * transform.rotation[1],
          .forward = sign * transform.rotation[2]};
}

CameraPose read_look_at(const JsonNode& node) {
  const JsonFields fields(node, {"eye", "target", "up"});
  const glm::dvec3 eye = fields.require("eye").vector(k_coordinate);
  const glm::dvec3 target = fields.require("target").vector(k_coordinate);
  glm::dvec3 up{0.0, 0.0, 1.0};
  if (const auto given = fields.find("up")) up = given->vector(k_coordinate);
  try {
    return look_at(eye, target, up);
  } catch (const Error& error) {
    node.fail(error.parts().problem, error.parts().expected, error.parts().found);
  }
}

CameraPose read_pose(const JsonNode& node) {
  const JsonFields fields(node,
                          {"look_at", "matrix", "quaternion", "translation", "convention", "direction"});
  const auto view = fields.find("look_at"), matrix = fields.find("matrix"),
             quaternion = fields.find("quaternion");
  if (int(view.has_value()) + int(matrix.has_value()) + int(quaternion.has_value()) != 1) {
    node.fail("ambiguous pose", "exactly one of \"look_at\", \"matrix\", \"quaternion\"",
              view || matrix || quaternion ? "several" : "none");
  }
  if (view) {
    const JsonFields alone(node, {"look_at"});
    return read_look_at(*view);
  }
  if (matrix) {
    const JsonFields allowed(node, {"matrix", "convention", "direction"});
    return pose_from_transform(allowed, transform_from_matrix(*matrix));
  }
  const JsonFields allowed(node, {"quaternion", "translation", "convention", "direction"});
  const glm::dmat3 rotation = read_quaternion(*quaternion);
  return pose_from_transform(allowed, {rotation, fields.require("translation").vector(k_coordinate)});
}

}  // namespace

std::string camera_json(const Camera& camera) {
  const CameraPose& pose = camera.pose;
  std::string rows;
  for (int axis = 0; axis < 3; ++axis) {
    rows += fmt::format("[{:.17g}, {:.17g}, {:.17g}, {:.17g}], ", pose.right[axis], pose.down[axis],
                        pose.forward[axis], pose.position[axis]);
  }
  const std::string distortion = std::visit(DistortionObject{}, camera.lens);
  return fmt::format(
      R"({{"version": 1, "model": "{}", "width": {}, "height": {}, )"
      R"("intrinsics": {{"fx": {:.17g}, "fy": {:.17g}, "cx": {:.17g}, "cy": {:.17g}}}, {})"
      R"("pose": {{"matrix": [{}[0, 0, 0, 1]], "convention": "opencv", "direction": "camera_to_world"}}{}}})",
      k_lens_names[camera.lens.index()], camera.width, camera.height, camera.fx, camera.fy, camera.cx,
      camera.cy, distortion.empty() ? "" : "\"distortion\": " + distortion + ", ", rows,
      camera.near > 0.0 ? fmt::format(", \"near\": {:.17g}", camera.near) : "");
}

JsonNode required(const JsonNode& node, std::string_view key) {
  if (const auto value = node.find(key)) return *value;
  node.fail(fmt::format("missing key \"{}\"", key), "", "");
}

Transform read_transform(const std::vector<JsonNode>& rows) {
  Transform transform;
  for (int row = 0; row < 3; ++row) {
    const std::vector<JsonNode> numbers = rows[static_cast<std::size_t>(row)].elements(4, 4);
    for (int column = 0; column < 3; ++column)
      transform.rotation[column][row] = numbers[static_cast<std::size_t>(column)].number(k_coordinate);
    transform.translation[row] = numbers[3].number(k_coordinate);
  }
  return transform;
}

Camera read_camera_node(const JsonNode& node) {
  const std::size_t model = model_of(node);
  const bool distorts = !is_model<PinholeLens>(model) && !is_model<OrthographicLens>(model) &&
                        !is_model<EquirectangularLens>(model);
  const JsonFields fields = distorts ? JsonFields(node, {"version", "description", "model", "width", "height",
                                                         "intrinsics", "distortion", "pose", "near"})
                                     : JsonFields(node, {"version", "description", "model", "width", "height",
                                                         "intrinsics", "pose", "near"});
  if (const auto version = fields.find("version")) read_version(*version);
  if (const auto description = fields.find("description")) description->text();
  const std::uint64_t width = fields.require("width").whole_number(1, k_max_image_side);
  const std::uint64_t height = fields.require("height").whole_number(1, k_max_image_side);
  if (width * height > k_max_pixels)
    node.fail("image too large", "at most 2^28 pixels", std::to_string(width * height) + " pixels");
  Camera camera{.width = static_cast<int>(width),
                .height = static_cast<int>(height),
                .pose = read_pose(fields.require("pose"))};
  read_intrinsics(fields.require("intrinsics"), model, camera);
  if (const auto near = fields.find("near")) camera.near = near->number({0.0, 1e9});
  if (distorts) camera.lens = read_distortion(fields.require("distortion"), model);
  try {
    check_camera(camera);
  } catch (const Error& error) {
    node.fail(error.parts().problem, error.parts().expected, error.parts().found);
  }
  return camera;
}

Camera parse_camera(std::string_view text, const std::filesystem::path& name) {
  const JsonDocument document = parse_json(std::string(text), name.string());
  const JsonNode node(document);
  const Camera camera = read_camera_node(node);
  if (!node.find("version")) node.fail("missing key \"version\"", "", "");
  return camera;
}

Camera read_camera(const std::filesystem::path& file) {
  return parse_camera(read_text_file(file), file);
}

}  // namespace alidade::camera
