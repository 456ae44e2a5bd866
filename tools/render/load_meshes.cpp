// SPDX-License-Identifier: MIT
#include "tools/render/load_meshes.h"

#include <memory>
#include <utility>

#include "renderer/mesh_surfaces.h"
#include "tools/cloud/mesh_files.h"
#include "tools/command.h"

namespace alidade::tools {

void add_mesh_files(const renderer::Scene& scene, std::vector<std::filesystem::path>& files) {
  for (const renderer::Object& object : scene.objects) {
    const auto* model = std::get_if<renderer::Model>(&object);
    if (model != nullptr && model->mesh) files.push_back(model->mesh->file);
  }
}

void load_meshes(renderer::Scene& scene, Verbosity verbosity) {
  for (renderer::Object& object : scene.objects) {
    auto* const model = std::get_if<renderer::Model>(&object);
    if (model == nullptr || !model->mesh) continue;
    const renderer::MeshFile& source = *model->mesh;
    TriangleMesh mesh = read_mesh_shown(source.file, source.placement, verbosity);
    model->surfaces = build_mesh_shown(verbosity, [&](const Progress& progress) {
      return std::make_shared<renderer::MeshSurfaces>(std::move(mesh), kept_name(source.file), progress);
    });
  }
}

}  // namespace alidade::tools
