// SPDX-License-Identifier: MIT
#include "renderer/image_fingerprint.h"

#include <fmt/format.h>
#include <span>
#include <utility>

#include "camera/camera_json.h"
#include "renderer/integrator.h"
#include "renderer/sky.h"

// Structs are taken apart by structured bindings: a field that is added to one of them does not compile here
// until it is written too.

namespace alidade::renderer {
namespace {

class Text {
 public:
  void add(double number) { add_word(fmt::format("{:.17g}", number)); }
  void add(int number) { add_word(std::to_string(number)); }
  void add(const std::string& text) { add_word(fmt::format("{}:{}", text.size(), text)); }
  /// What is in a file counts by its checksum: parts of an image come from machines with other folders.
  void add(const std::filesystem::path& path) { add(path.filename().string()); }
  void add(const Rgb& color) { add_all(double{color.r}, double{color.g}, double{color.b}); }
  void add(const glm::dvec3& position) { add_all(position.x, position.y, position.z); }

  template <class Enum>
  requires std::is_enum_v<Enum>
  void add(Enum value) { add(static_cast<int>(value)); }
  template <class Value>
  void add(const std::optional<Value>& value) {
    if (value)
      add(*value);
    else
      add_word("none");
  }
  template <class Value>
  void add(const std::vector<Value>& values) {
    add(static_cast<int>(values.size()));
    for (const Value& value : values) add(value);
  }
  template <class... Alternatives>
  void add(const std::variant<Alternatives...>& value) {
    add(static_cast<int>(value.index()));
    std::visit([this](const auto& alternative) { this->add(alternative); }, value);
  }

  void add(const Lambertian& material) { add_fields<1>(material); }
  void add(const Metal& material) { add_fields<2>(material); }
  void add(const Dielectric& material) { add_fields<1>(material); }
  void add(const Emissive& material) { add_fields<1>(material); }
  void add(const AdaptedRadius& radius) { add_fields<3>(radius); }
  void add(const Color16& color) { add_all(int{color.x}, int{color.y}, int{color.z}); }
  void add(const image::ValueRange& range) { add_fields<2>(range); }
  void add(const image::ClassColor& each) {
    const auto& [number, color, name] = each;
    add_all(int{number}, color, name);
  }
  void add(const image::PointColoring& coloring) {
    const auto& [by, attribute, map, range, percentiles, classes] = coloring;
    add_all(by, attribute, map, range, percentiles, classes);
  }
  void add(const CloudSettings& cloud) {
    const auto& [files, partial, color_depth, radius, adapted_radius, hits, color, material, normals, shape,
                 max_level] = cloud;
    add_all(files, partial, color_depth, radius, adapted_radius, hits, color, material, normals, shape,
            max_level);
  }
  void add(const Sphere& sphere) { add_fields<3>(sphere); }
  void add(const GroundPlane& plane) { add_fields<2>(plane); }
  void add(const Model& model) {
    const auto& [surfaces, material, mesh] = model;
    // The name of a mesh has file, placement and a checksum.
    add_all(surfaces->name(), material);
  }
  void add(const ConstantSky& sky) { add_fields<1>(sky); }
  void add(const GradientSky& sky) { add_fields<2>(sky); }
  void add(const ImageSky& sky) {
    const auto& [file, scale, rotation, image] = sky;
    add_all(file, scale, rotation);
    if (!image) return;
    const image::SkyPixels& pixels = image->pixels();
    add_all(pixels.width, pixels.height);
    add_word(fmt::format("{:016x}", checksum(std::as_bytes(std::span(pixels.values)))));
  }
  void add(const geo::Sun& sun) {
    const auto& [azimuth, elevation, irradiance, angular_diameter] = sun;
    add_all(azimuth, elevation, irradiance, angular_diameter);
  }

  std::string take() { return std::move(text_); }

 private:
  template <class... Values>
  void add_all(const Values&... values) {
    (add(values), ...);
  }

  /// Of a struct with so many fields.
  template <int count, class Struct>
  void add_fields(const Struct& fields) {
    if constexpr (count == 1) {
      const auto& [a] = fields;
      add(a);
    } else if constexpr (count == 2) {
      const auto& [a, b] = fields;
      add_all(a, b);
    } else {
      const auto& [a, b, c] = fields;
      add_all(a, b, c);
    }
  }
  void add_word(const std::string& word) {
    if (!text_.empty()) text_ += ' ';
    text_ += word;
  }

  std::string text_;
};

std::string cloud_checksum(const LoadedCloud& cloud) {
  std::vector<std::uint64_t> sums;
  if (cloud.index_checksum)
    sums.push_back(*cloud.index_checksum);
  else
    append_tree_checksums(cloud.octree.view(), sums);
  append_checksums({std::as_bytes(std::span(cloud.colors))}, sums);
  return fmt::format("{:016x}", checksum(std::as_bytes(std::span(sums))));
}

std::string bounds_text(const Bounds& bounds) {
  if (bounds.empty()) return "none";
  return fmt::format("{:.17g} {:.17g} {:.17g} to {:.17g} {:.17g} {:.17g}", bounds.min.x, bounds.min.y,
                     bounds.min.z, bounds.max.x, bounds.max.y, bounds.max.z);
}

/// The noise requested; exposure determines how dark an image may be before its noise does not matter.
std::string noise_text(const RenderOptions& options, const Scene& scene) {
  if (!options.target_noise) return "none";
  return fmt::format("{:.17g} at exposure {:.17g}", *options.target_noise, scene.output.exposure);
}

std::string file_names(const CloudSettings& settings) {
  std::string names;
  for (const std::filesystem::path& file : settings.files)
    names += (names.empty() ? "" : ", ") + file.filename().string();
  return names;
}

}  // namespace

template <class Part>
std::string text_of(const Part& part) {
  Text text;
  text.add(part);
  return text.take();
}
template std::string text_of(const CloudSettings&);
template std::string text_of(const std::vector<Object>&);
template std::string text_of(const Sky&);
template std::string text_of(const std::optional<geo::Sun>&);

Fingerprint image_fingerprint(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options) {
  // Taken apart as the scene is: a new setting must be written here, too.
  const auto& [samples, max_bounces, seed, mode, ao_distance] = scene.render;
  Fingerprint fingerprint{
      {"picture", options.checkpoint ? options.checkpoint->image : ""},
      {"part", part_text(options.part)},
      {"picture version", std::to_string(k_image_version)},
      {"seed", std::to_string(seed)},
      {"number of samples", std::to_string(samples)},
      {"number of bounces", std::to_string(max_bounces)},
      {"mode", std::string(k_modes[static_cast<std::size_t>(mode)].name)},
      {"cloud files", scene.cloud ? file_names(*scene.cloud) : "none"},
  };
  const auto add = [&](std::string name, std::string value) {
    fingerprint.push_back({std::move(name), std::move(value)});
  };
  if (cloud != nullptr) {
    add("number of points", std::to_string(cloud->octree.size()));
    add("radius", fmt::format("{:.17g}", cloud->radius));
    add("radius factor", fmt::format("{:.17g}", cloud->spacing_factor));
    add("neighbours for radii", std::to_string(cloud->octree.view().spacing_neighbours));
  }
  add("cloud settings", scene.cloud ? text_of(*scene.cloud) : "none");
  if (cloud != nullptr) {
    add("bounds of the points", bounds_text(cloud->octree.bounds()));
    add("points and colours", cloud_checksum(*cloud));
  }
  const Fingerprint rest{
      {"range of ambient occlusion", fmt::format("{:.17g} {:.17g}", ao_distance.value_or(0.0),
                                                 ambient_occlusion_distance(scene.render, cloud))},
      {"target noise", noise_text(options, scene)},
      {"noise sums", keeps_noise(options) ? "kept" : "not kept"},
      {"camera", scene.camera ? camera::camera_json(*scene.camera) : "none"},
      {"objects", text_of(scene.objects)},
      {"sky", text_of(scene.sky)},
      {"sun", text_of(scene.sun)},
  };
  if (scene.output.transparent || scene.output.background) fingerprint.push_back({"sky", "transparent"});
  fingerprint.insert(fingerprint.end(), rest.begin(), rest.end());
  return fingerprint;
}

}  // namespace alidade::renderer
