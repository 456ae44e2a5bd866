// SPDX-License-Identifier: MIT
#include "renderer/picture_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "octree/checksum.h"
#include "renderer/camera/camera_json.h"
#include "renderer/quick_modes.h"
#include "renderer/scene_text.h"

namespace alidade {
namespace {

template <class Value>
void add_checksum(const Value* values, std::size_t count, std::vector<std::uint64_t>& sums) {
  sums.push_back(values == nullptr ? 0 : checksum(std::as_bytes(std::span(values, count))));
}

std::string cloud_checksum(const LoadedCloud& cloud) {
  std::vector<std::uint64_t> sums;
  if (cloud.index_checksum) {
    sums.push_back(*cloud.index_checksum);
  } else {
    const TreeView& tree = cloud.octree.view();
    add_checksum(tree.nodes, tree.node_count, sums);
    add_checksum(tree.coordinates, 3 * std::size_t{tree.point_count}, sums);
    add_checksum(tree.ids, tree.point_count, sums);
    add_checksum(tree.positions, tree.exact_count(), sums);
  }
  add_checksum(cloud.colors.data(), cloud.colors.size(), sums);
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

/// Whether a byte is one within a character of UTF-8.
bool is_continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

/// What a message can show of two values, which differ: of long ones, from the word on that does.
std::pair<std::string, std::string> telling_parts(const std::string& a, const std::string& b) {
  constexpr std::size_t k_longest = 60, k_part = 40, k_word = 20;
  if (a.size() <= k_longest && b.size() <= k_longest) return {a, b};
  const auto difference = static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
  std::size_t begin = difference == 0 ? 0 : a.find_last_of(" ,{[", difference - 1) + 1;
  if (difference - begin > k_word) begin = difference;
  while (begin > 0 && begin < a.size() && is_continuation(a[begin])) --begin;
  const auto part = [begin](const std::string& text) {
    std::size_t end = std::min(begin + k_part, text.size());
    while (end < text.size() && is_continuation(text[end])) ++end;
    return (begin > 0 ? "..." : "") + text.substr(begin, end - begin) + (end < text.size() ? "..." : "");
  };
  return {part(a), part(b)};
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

void check_identity(const PictureIdentity& made, const PictureIdentity& asked, const std::string& file) {
  for (std::size_t i = 0; i < std::max(made.size(), asked.size()); ++i) {
    const IdentityEntry none{"cloud", "none"};
    const IdentityEntry &before = i < made.size() ? made[i] : none, &now = i < asked.size() ? asked[i] : none;
    if (before == now) continue;
    const bool comparable = before.name == now.name;
    const auto [made_with, asked_for] = telling_parts(before.value, now.value);
    throw Error(
        {.file = file,
         .problem = fmt::format("is the checkpoint of another picture: made with {} {}, asked for {}{}",
                                before.name, made_with, comparable ? "" : now.name + " ", asked_for),
         .expected = "the same scene, cloud and options, or no --resume"});
  }
}

}  // namespace alidade
