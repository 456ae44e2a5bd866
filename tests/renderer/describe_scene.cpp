// SPDX-License-Identifier: MIT
#include "tests/renderer/describe_scene.h"

#include <fmt/format.h>

namespace alidade::test {

using namespace geo;
using namespace image;
using namespace camera;
using namespace renderer;

namespace {

std::string text(double value) {
  return fmt::format("{:.17g} ", value);
}
std::string text(const glm::dvec3& v) {
  return text(v.x) + text(v.y) + text(v.z);
}
std::string text(const std::optional<Rgb>& color) {
  return color ? text(glm::dvec3(*color)) : std::string("own ");
}

std::string text(const Material& material) {
  struct {
    std::string operator()(const Lambertian& m) const { return fmt::format("lambertian {}", text(m.albedo)); }
    std::string operator()(const Metal& m) const {
      return fmt::format("metal {}{}", text(m.albedo), text(m.roughness));
    }
    std::string operator()(const Dielectric& m) const {
      return fmt::format("dielectric {}", text(m.refractive_index));
    }
    std::string operator()(const Emissive& m) const {
      return fmt::format("emissive {}", text(glm::dvec3(m.radiance)));
    }
  } visitor;
  return std::visit(visitor, material);
}

std::string text(const Object& object) {
  struct {
    std::string operator()(const Sphere& s) const {
      return fmt::format("sphere {}{}{}", text(s.center), text(s.radius), text(s.material));
    }
    std::string operator()(const Model& m) const {
      if (!m.mesh) return fmt::format("model {} {}", m.name, text(m.material));
      const MeshPlacement& placement = m.mesh->placement;
      return fmt::format("mesh {} {}{}{}{}", m.mesh->file.string(), text(placement.scale),
                         text(placement.rotate_z), text(placement.translate), text(m.material));
    }
    std::string operator()(const GroundPlane& p) const {
      return fmt::format("plane {}{}", text(p.height), text(p.material));
    }
  } visitor;
  return std::visit(visitor, object);
}

std::string text(const Sky& sky) {
  struct {
    std::string operator()(const ConstantSky& s) const {
      return fmt::format("constant {}", text(glm::dvec3(s.radiance)));
    }
    std::string operator()(const GradientSky& s) const {
      return fmt::format("gradient {}{}", text(glm::dvec3(s.horizon)), text(glm::dvec3(s.zenith)));
    }
    std::string operator()(const ImageSky& s) const {
      return fmt::format("image {} {}{}", s.file.string(), text(s.scale), text(s.rotation));
    }
  } visitor;
  return std::visit(visitor, sky);
}

std::string text(const PointColoring& color) {
  std::string result = fmt::format("color {} ", color_word(color));
  if (color.map) result += fmt::format("{} ", name(*color.map));
  if (color.range) result += text(color.range->low) + text(color.range->high);
  if (color.percentiles != ValueRange{1, 99})
    result += "percentiles " + text(color.percentiles.low) + text(color.percentiles.high);
  for (const ClassColor& each : color.classes)
    result += fmt::format("class {} {}'{}' ", each.number, text(glm::dvec3(each.color)), each.name);
  return result;
}

std::string text(const CloudSettings& cloud) {
  std::string result = "cloud ";
  for (const auto& file : cloud.files) result += file.string() + " ";
  result += fmt::format("depth {} hits {} {}normals {} ", int(cloud.color_depth), int(cloud.hits),
                        text(cloud.color), int(cloud.normals));
  if (cloud.shape != PointShape::sphere) result += fmt::format("shape {} ", int(cloud.shape));
  if (cloud.partial) result += "partial ";
  if (cloud.max_level != k_max_level) result += fmt::format("levels {} ", cloud.max_level);
  if (cloud.adapted_radius) {
    const AdaptedRadius& radius = *cloud.adapted_radius;
    result += fmt::format("neighbours {} factor {} max {} ", radius.neighbours,
                          radius.factor ? text(*radius.factor) : "default ",
                          radius.max ? text(*radius.max) : "none ");
  }
  return result + (cloud.radius ? text(*cloud.radius) : "auto ") + text(cloud.material);
}

std::string text(const Distortion& distortion) {
  std::string result;
  for (const double each : distortion.radial) result += text(each);
  for (const double each : distortion.denominator) result += text(each);
  for (const double each : distortion.prism) result += text(each);
  return result + text(distortion.p1) + text(distortion.p2) + (distortion.after_radial ? "after " : "");
}

std::string text(const Lens& lens) {
  struct {
    std::string operator()(const BrownLens& l) const { return text(l.distortion); }
    std::string operator()(const FisheyeLens& l) const { return text(l.distortion); }
    std::string operator()(const FieldOfViewLens& l) const { return text(l.omega); }
    std::string operator()(const DivisionLens& l) const { return text(l.k); }
    std::string operator()(const UnifiedLens& l) const { return text(l.alpha) + text(l.beta); }
    std::string operator()(const DualLens& l) const { return text(l.transition) + text(l.distortion); }
    std::string operator()(const PinholeLens&) const { return ""; }
    std::string operator()(const OrthographicLens&) const { return ""; }
    std::string operator()(const EquirectangularLens&) const { return ""; }
  } visitor;
  return std::string(k_lens_names[lens.index()]) + " " + std::visit(visitor, lens);
}

}  // namespace

std::string describe(const Camera& camera) {
  return fmt::format("{} x {} ", camera.width, camera.height) + text(camera.fx) + text(camera.fy) +
         text(camera.cx) + text(camera.cy) + text(camera.pose.position) + text(camera.pose.right) +
         text(camera.pose.down) + text(camera.pose.forward) + text(camera.lens);
}

std::string describe(const Scene& scene) {
  std::string result = scene.cloud ? text(*scene.cloud) : "no cloud";
  for (const Object& object : scene.objects) result += fmt::format("\n{}", text(object));
  result += fmt::format("\nsky {}", text(scene.sky));
  if (const auto& sun = scene.sun) {
    result += fmt::format("\nsun {}{}{}{}", text(sun->azimuth), text(sun->elevation),
                          text(glm::dvec3(sun->irradiance)), text(sun->angular_diameter));
  }
  if (const auto& sun = scene.sun_by_time) {
    result += fmt::format(
        "\nsun on {} at {}{}{}{}{}{}{}", date_time_text(sun->moment),
        sun->latitude ? text(*sun->latitude) : "auto ", sun->longitude ? text(*sun->longitude) : "auto ",
        text(sun->height), text(sun->pressure), text(sun->temperature),
        sun->irradiance ? text(glm::dvec3(*sun->irradiance)) : "auto ", text(sun->angular_diameter));
  }
  result += fmt::format("\ncamera {}", scene.camera ? describe(*scene.camera) : "chosen");
  const RenderSettings& render = scene.render;
  result += fmt::format("\nrender {} {} {}", render.samples, render.max_bounces, render.seed);
  if (render.mode != RenderMode::path) result += fmt::format(" mode {}", int(render.mode));
  if (render.ao_distance) result += fmt::format(" near {}", text(*render.ao_distance));
  const OutputSettings& output = scene.output;
  result += fmt::format("\noutput '{}' half {} {}", output.file.string(), output.half, text(output.exposure));
  for (const Layer layer : output.layers) result += fmt::format("{} ", int(layer));
  return result;
}

}  // namespace alidade::test
