// SPDX-License-Identifier: MIT
#include "renderer/image_metadata.h"

#include <fmt/format.h>

#include <cmath>

#include "camera/camera_json.h"

namespace alidade::renderer {
namespace {

std::string vector_text(const glm::dvec3& v) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", v.x, v.y, v.z);
}

std::string camera_text(const camera::Camera& camera) {
  const camera::CameraPose& pose = camera.pose;
  return fmt::format(
      "{}, {} x {} pixels, focal length {:.3f} x {:.3f}, principal point {:.3f} {:.3f}, at {:.3f} "
      "{:.3f} {:.3f}, "
      "looking along {:.6f} {:.6f} {:.6f}",
      camera::k_lens_names[camera.lens.index()], camera.width, camera.height, camera.fx, camera.fy, camera.cx,
      camera.cy, pose.position.x, pose.position.y, pose.position.z, pose.forward.x, pose.forward.y,
      pose.forward.z);
}

}  // namespace

glm::dvec3 position_offset(const camera::Camera& camera) {
  constexpr double k_step = 10000.0;
  glm::dvec3 offset{0.0};
  // Adding 0 turns -0 into 0.
  for (int axis = 0; axis < 3; ++axis)
    offset[axis] = std::round(camera.pose.position[axis] / k_step) * k_step + 0.0;
  return offset;
}

std::vector<std::pair<std::string, std::string>> metadata_texts(const ImageMetadata& metadata) {
  std::vector<std::pair<std::string, std::string>> texts{{"Software", "Alidade " ALIDADE_VERSION}};
  const auto add = [&](std::string key, std::string text) {
    if (!text.empty()) texts.emplace_back(std::move(key), std::move(text));
  };
  std::string files;
  for (const std::string& file : metadata.cloud_files) files += (files.empty() ? "" : "\n") + file;
  add("alidade:version", ALIDADE_VERSION);
  add("alidade:command", metadata.command);
  add("alidade:camera", camera_text(metadata.camera));
  add("alidade:camera_json", camera::camera_json(metadata.camera));
  add("alidade:position_offset", vector_text(position_offset(metadata.camera)));
  add("alidade:samples", std::to_string(metadata.render.samples));
  add("alidade:max_bounces", std::to_string(metadata.render.max_bounces));
  add("alidade:seed", std::to_string(metadata.render.seed));
  if (metadata.render.mode != RenderMode::path)
    add("alidade:mode", std::string(k_modes[static_cast<std::size_t>(metadata.render.mode)].name));
  if (metadata.render.mode == RenderMode::ambient_occlusion && metadata.render.ao_distance)
    add("alidade:ao_distance", fmt::format("{:.17g}", *metadata.render.ao_distance));
  add("alidade:cloud_files", files);
  if (!files.empty()) add("alidade:cloud_offset", vector_text(metadata.cloud_offset));
  add("alidade:crs", metadata.crs.wkt);
  if (metadata.radius > 0.0) add("alidade:radius", fmt::format("{:.17g}", metadata.radius));
  for (const auto& [key, text] : metadata.further) add(key, text);
  return texts;
}

image::ImageFacts image_facts(const ImageMetadata& metadata, const image::OutputSettings& output) {
  image::ImageFacts facts{.texts = metadata_texts(metadata),
                          .position_offset = position_offset(metadata.camera),
                          .crs = metadata.crs};
  if (image::image_format(output.file) == image::ImageFormat::geotiff)
    facts.ground = camera::ground_transform(metadata.camera);
  return facts;
}

}  // namespace alidade::renderer
