// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/triangle_mesh.h"
#include "tools/console.h"
#include "tools/options.h"

// What commands with --mesh have in common.

namespace alidade::tools {

/// Declares --mesh, which is repeatable; appends its files to `files`. `purpose`: the use of the
/// triangles, the end of the help text.
inline void add_mesh_option(const Options& command, const std::string& purpose,
                            std::vector<std::filesystem::path>& files) {
  command.values("--mesh", "FILE",
                 "PLY or OBJ file of triangles in world coordinates, such as a planned building, " + purpose +
                     "; repeatable",
                 [&files](const std::string& text) { files.emplace_back(text); });
}

/// Reads a mesh, shows progress, and prints warnings and how large it is. Errors: as read_mesh().
inline TriangleMesh read_mesh_shown(const std::filesystem::path& file, const MeshPlacement& placement,
                                    Verbosity verbosity) {
  TriangleMesh mesh = with_progress("loading mesh", "B", verbosity, [&](const Progress& progress) {
    return read_mesh(file, placement, progress);
  });
  say_warnings(verbosity, mesh.warnings);
  say_note(verbosity, fmt::format("{} triangles from {}", mesh.triangles.size(), file.string()));
  return mesh;
}

/// Returns what make(progress) returns, which builds a tree of triangles; shows its progress.
template <class Make>
auto build_mesh_shown(Verbosity verbosity, const Make& make) {
  return with_progress("sorting triangles", "triangles", verbosity, make);
}

}  // namespace alidade::tools
