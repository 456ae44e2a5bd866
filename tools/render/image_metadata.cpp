// SPDX-License-Identifier: MIT
#include "tools/render/image_metadata.h"

#include <fmt/format.h>

#include "image/color_points.h"
#include "tools/command.h"

namespace alidade::tools {

renderer::ImageMetadata image_metadata(const renderer::Scene& scene, const View& view,
                                       const renderer::LoadedCloud* cloud, const CommandLine& words) {
  renderer::ImageMetadata metadata;
  metadata.camera = view.camera;
  metadata.render = scene.render;
  metadata.command = picture_command(words);
  if (!scene.sun_origin.empty()) metadata.further.emplace_back("alidade:sun", scene.sun_origin);
  if (!view.name.empty()) metadata.further.emplace_back("alidade:camera_name", view.name);
  for (const renderer::Object& object : scene.objects)
    if (const auto* model = std::get_if<renderer::Model>(&object))
      metadata.further.emplace_back(model->mesh ? "alidade:mesh" : "alidade:site", model->surfaces->name());
  if (cloud == nullptr) return metadata;
  if (scene.cloud->shape != renderer::PointShape::sphere)
    metadata.further.emplace_back("alidade:surface",
                                  scene.cloud->shape == renderer::PointShape::disc ? "disc" : "blend");
  for (const CloudFile& file : cloud->files) metadata.cloud_files.push_back(kept_name(file.path));
  metadata.cloud_offset = cloud->octree.lattice().offset;
  metadata.crs = cloud->crs;
  metadata.radius = cloud->radius;
  if (cloud->spacing_factor > 0.0) {
    metadata.further.emplace_back("alidade:radius_factor", fmt::format("{:.17g}", cloud->spacing_factor));
    metadata.further.emplace_back("alidade:radius_neighbours",
                                  std::to_string(cloud->octree.view().spacing_neighbours));
  }
  for (const auto& text : image::color_metadata(cloud->color)) metadata.further.push_back(text);
  return metadata;
}

}  // namespace alidade::tools
