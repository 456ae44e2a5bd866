// SPDX-License-Identifier: MIT
#include "renderer/picture_identity.h"

#include <fmt/format.h>

#include <span>
#include <utility>

#include "base/fingerprint.h"
#include "camera/camera_json.h"
#include "renderer/render_modes.h"
#include "renderer/scene_text.h"

namespace alidade {
namespace {

std::string cloud_checksum(const LoadedCloud& cloud) {
  std::vector<std::uint64_t> sums;
  if (cloud.index_checksum) {
    sums.push_back(*cloud.index_checksum);
  } else {
    append_tree_checksums(cloud.octree.view(), sums);
  }
  const std::span colors(cloud.colors);
  sums.push_back(colors.data() == nullptr ? 0 : checksum(std::as_bytes(colors)));
  return fmt::format("{:016x}", checksum(std::as_bytes(std::span(sums))));
}

std::string bounds_text(const Bounds& bounds) {
  if (bounds.empty()) return "none";
  return fmt::format("{:.17g} {:.17g} {:.17g} to {:.17g} {:.17g} {:.17g}", bounds.min.x, bounds.min.y,
                     bounds.min.z, bounds.max.x, bounds.max.y, bounds.max.z);
}

/// The noise asked for; exposure tells how dark a picture may be before its noise does not matter.
std::string noise_text(const RenderOptions& options, const Scene& scene) {
  if (!options.target_noise) return "none";
  return fmt::format("{:.17g} at exposure {:.17g}", *options.target_noise, scene.output.exposure);
}

std::string file_names(const CloudSettings& settings) {
  std::string names;
  for (const std::filesystem::path& file : settings.files)
    names += (names.empty() ? "" : ", ") + file.string();
  return names;
}

}  // namespace

PictureIdentity picture_identity(const Scene& scene, const LoadedCloud* cloud, const RenderOptions& options) {
  // Taken apart as the scene is (renderer/scene_text.cpp): a new setting must be written here, too.
  const auto& [samples, max_bounces, seed, mode, ao_distance] = scene.render;
  PictureIdentity identity{
      {"picture", options.checkpoint ? options.checkpoint->picture : ""},
      {"picture version", std::to_string(k_picture_version)},
      {"seed", std::to_string(seed)},
      {"number of samples", std::to_string(samples)},
      {"number of bounces", std::to_string(max_bounces)},
      {"mode", std::string(k_modes[static_cast<std::size_t>(mode)].name)},
      {"cloud files", scene.cloud ? file_names(*scene.cloud) : "none"},
  };
  const auto add = [&](std::string name, std::string value) {
    identity.push_back({std::move(name), std::move(value)});
  };
  if (cloud != nullptr) {
    add("number of points", std::to_string(cloud->octree.size()));
    add("radius", fmt::format("{:.17g}", cloud->radius));
    add("radius over spacing", fmt::format("{:.17g}", cloud->spacing_factor));
    add("neighbour of spacings", std::to_string(cloud->octree.view().spacing_neighbours));
  }
  add("cloud settings", scene.cloud ? text_of(*scene.cloud) : "none");
  if (cloud != nullptr) {
    add("bounds of the points", bounds_text(cloud->octree.bounds()));
    add("points and colours", cloud_checksum(*cloud));
  }
  const PictureIdentity rest{
      {"distance of ambient occlusion", fmt::format("{:.17g} {:.17g}", ao_distance.value_or(0.0),
                                                    ambient_occlusion_distance(scene.render, cloud))},
      {"target noise", noise_text(options, scene)},
      {"noise sums", keeps_noise(options) ? "kept" : "not kept"},
      {"camera", scene.camera ? camera_json(*scene.camera) : "none"},
      {"objects", text_of(scene.objects)},
      {"sky", text_of(scene.sky)},
      {"sun", text_of(scene.sun)},
  };
  identity.insert(identity.end(), rest.begin(), rest.end());
  return identity;
}

}  // namespace alidade
