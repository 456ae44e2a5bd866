// SPDX-License-Identifier: MIT
#include "renderer/image_fingerprint.h"

#include <fmt/format.h>
#include <span>
#include <string_view>
#include <utility>

#include "camera/camera_json.h"
#include "renderer/integrator.h"
#include "renderer/scene_forms.h"
#include "renderer/sky.h"
#include "renderer/sun_forms.h"

namespace alidade::renderer {
namespace {

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

/// Names of files and attributes that are not UTF-8 count by a checksum.
std::string text_of(const Json& value) {
  constexpr std::string_view k_replaced = "\uFFFD";
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.find(k_replaced) != text.npos) {
    const std::vector<std::uint8_t> bytes = Json::to_cbor(value);
    text += fmt::format(" {:016x}", checksum(std::as_bytes(std::span(bytes))));
  }
  return text;
}

}  // namespace

// What is in a file counts by its checksum: parts of an image come from machines with other folders.

std::string text_of(CloudSettings settings) {
  for (std::filesystem::path& file : settings.files) file = file.filename();
  return text_of(cloud_form().write(settings));
}

std::string text_of(const std::vector<Object>& objects) {
  Json all = Json::array();
  for (const Object& object : objects) {
    // The name of a mesh has file, placement and a checksum.
    const Model* const model = std::get_if<Model>(&object);
    if (model == nullptr) {
      all.push_back(scene_object_form().write(object));
      continue;
    }
    if (model->name.empty())
      throw Error({.problem = "a model has no name", .expected = "one that tells its surfaces from others"});
    all.push_back({model->name, material_form().write(model->material)});
  }
  return text_of(all);
}

std::string text_of(Sky sky) {
  ImageSky* const image = std::get_if<ImageSky>(&sky);
  if (image == nullptr) return text_of(sky_form().write(sky));
  image->file = image->file.filename();
  Json written = sky_form().write(sky);
  if (image->image) {
    const image::SkyPixels& pixels = image->image->pixels();
    written["pixels"] = {pixels.width, pixels.height,
                         fmt::format("{:016x}", checksum(std::as_bytes(std::span(pixels.values))))};
  }
  return text_of(written);
}

std::string text_of(const std::optional<geo::Sun>& sun) {
  return sun ? text_of(sun_form().write(*sun)) : "none";
}

Fingerprint image_fingerprint(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options) {
  Fingerprint fingerprint{
      {"picture", options.checkpoint ? options.checkpoint->image : ""},
      {"part", part_text(options.part)},
      {"picture version", std::to_string(k_image_version)},
  };
  const auto add = [&](std::string name, std::string value) {
    fingerprint.push_back({std::move(name), std::move(value)});
  };
  const Json settings = render_form().write(scene.render);
  for (const auto& [key, value] : settings.items()) add(key, text_of(value));
  add("cloud files", scene.cloud ? file_names(*scene.cloud) : "none");
  if (cloud != nullptr) {
    add("number of points", std::to_string(cloud->octree.size()));
    add("radius", fmt::format("{:.17g}", cloud->radius));
    add("radius factor", fmt::format("{:.17g}", cloud->spacing_factor));
    add("neighbours for radii", std::to_string(cloud->octree.layers().spacing_neighbours));
  }
  add("cloud settings", scene.cloud ? text_of(*scene.cloud) : "none");
  if (cloud != nullptr) {
    add("bounds of the points", bounds_text(cloud->octree.bounds()));
    add("points and colours", cloud_checksum(*cloud));
  }
  const Fingerprint rest{
      {"range of ambient occlusion", fmt::format("{:.17g}", ambient_occlusion_distance(scene.render, cloud))},
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
