// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "mesh/triangle_mesh.h"
#include "tools/console.h"
#include "tools/options.h"

// What commands with --mesh have in common.

namespace alidade::tools {

/// Declares --mesh, which may be given again; appends its files to `files`. `purpose`: the use of the
/// triangles, the end of the help text.
void add_mesh_option(const Options& command, const std::string& purpose,
                     std::vector<std::filesystem::path>& files);

/// Reads a mesh, shows progress, and prints warnings and how large it is. Errors: as read_mesh().
TriangleMesh read_mesh_shown(const std::filesystem::path& file, const MeshPlacement& placement,
                             Verbosity verbosity);

/// Returns what make(progress) returns, which builds a tree of triangles; shows its progress.
template <class Make>
auto build_mesh_shown(Verbosity verbosity, const Make& make) {
  return with_progress("sorting triangles", "triangles", verbosity, make);
}

}  // namespace alidade::tools
