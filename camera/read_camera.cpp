// SPDX-License-Identifier: MIT
#include <numbers>
#include <utility>

#include "camera/camera.h"
#include "renderer/read_scene_parts.h"

namespace alidade {
namespace {

// Wider or narrower views are mistakes; the focal length stays an ordinary number.
constexpr NumberRange k_field_of_view{1e-6, 179.999};
constexpr NumberRange k_focal_length{1e-6, 1e12};
constexpr NumberRange k_principal_point{-1e9, 1e9};
constexpr NumberRange k_resolution{1e-9, 1e6};
constexpr NumberRange k_coefficient{-1e6, 1e6};

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
    // The same camera on its side.
    const Camera turned =
        pinhole_from_fov(camera.height, camera.width, across->number(k_field_of_view), camera.pose);
    center(camera, turned.fx, turned.fy);
  } else if (has_focal_length(fields)) {
    read_focal_lengths(fields, camera);
  } else {
    node.fail("no focal length", R"("vertical_fov", "horizontal_fov" or "fx", "fy", "cx", "cy")",
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

}  // namespace

std::size_t model_of(const JsonNode& camera) {
  if (const auto model = camera.find("model")) return model->choice(k_lens_names);
  const JsonFields fields(
      camera, {"version", "description", "model", "width", "height", "intrinsics", "distortion", "pose"});
  return fields.require("model").choice(k_lens_names);
}

bool is_distorting(std::size_t model) {
  return !is_model<PinholeLens>(model) && !is_model<OrthographicLens>(model) &&
         !is_model<EquirectangularLens>(model);
}

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

Lens read_distortion(const JsonNode& node, std::size_t model) {
  if (is_model<BrownLens>(model)) return read_brown(node);
  if (is_model<FisheyeLens>(model)) return read_fisheye(node);
  if (is_model<UnifiedLens>(model)) return read_unified(node);
  if (is_model<DualLens>(model)) return read_dual(node);
  if (is_model<FieldOfViewLens>(model))
    return FieldOfViewLens{JsonFields(node, {"omega"}).require("omega").number({-3.14159, 3.14159})};
  return DivisionLens{JsonFields(node, {"k"}).require("k").number(k_coefficient)};
}

}  // namespace alidade
