// SPDX-License-Identifier: MIT
#include "tools/render/load_meshes.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "renderer/mesh_surfaces.h"

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
    std::vector<std::string> warnings;
    ProgressLine reading("loading mesh", "B", verbosity);
    std::optional<ProgressLine> building;
    const Progress build = [&](std::uint64_t done, std::uint64_t total) {
      if (!building) {
        reading.finish();
        building.emplace("sorting triangles", "triangles", verbosity);
      }
      return building->callback()(done, total);
    };
    renderer::load_mesh(*model, warnings, reading.callback(), build);
    (building ? *building : reading).finish();
    say_warnings(verbosity, warnings);
    if (verbosity == Verbosity::quiet) continue;
    const auto& mesh = static_cast<const renderer::MeshSurfaces&>(*model->surfaces);
    say_note(fmt::format("{} triangles from {}", mesh.tree().triangle_count(), model->mesh->file.string()));
  }
}

}  // namespace alidade::tools
