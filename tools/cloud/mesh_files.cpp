// SPDX-License-Identifier: MIT
#include "tools/cloud/mesh_files.h"

#include <fmt/format.h>

namespace alidade::tools {

void add_mesh_option(const Options& command, const std::string& purpose,
                     std::vector<std::filesystem::path>& files) {
  command.values("--mesh", "FILE",
                 "PLY or OBJ file of triangles in world coordinates, such as a planned building, " + purpose +
                     "; may be given again",
                 [&files](const std::string& text) { files.emplace_back(text); });
}

TriangleMesh read_mesh_shown(const std::filesystem::path& file, const MeshPlacement& placement,
                             Verbosity verbosity) {
  TriangleMesh mesh = with_progress("loading mesh", "B", verbosity, [&](const Progress& progress) {
    return read_mesh(file, placement, progress);
  });
  say_warnings(verbosity, mesh.warnings);
  say_note(verbosity, fmt::format("{} triangles from {}", mesh.triangles.size(), file.string()));
  return mesh;
}

}  // namespace alidade::tools
