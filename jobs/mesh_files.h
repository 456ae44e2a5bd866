// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <filesystem>
#include <string>
#include <utility>

#include "jobs/fields.h"
#include "jobs/listener.h"
#include "mesh/triangle_mesh.h"

// What jobs with meshes have in common.

namespace alidade::jobs {

/// Declares --mesh, which is repeatable; `take` gets each of its files. `purpose`: the use of the triangles,
/// the end of the help text.
inline void add_mesh_field(const Fields& fields, const std::string& purpose, Fields::Take take) {
  fields.values("--mesh", "FILE",
                "PLY or OBJ file of triangles in world coordinates, such as a planned building, " + purpose +
                    "; repeatable",
                [take = std::move(take)](const std::string& file) {
                  check_mesh_name(file);
                  take(file);
                });
}

/// Reads a mesh as one stage; warns of what it warns of, and notes how large it is. Errors: as read_mesh().
inline TriangleMesh load_mesh(const std::filesystem::path& file, const MeshPlacement& placement,
                              Listener& listener) {
  TriangleMesh mesh = in_stage(listener, "loading mesh", "B", [&](const Progress& progress) {
    return read_mesh(file, placement, progress);
  });
  warn_all(listener, mesh.warnings);
  listener.note(fmt::format("{} triangles from {}", mesh.triangles.size(), file.string()));
  return mesh;
}

/// Returns what make(progress) returns, which builds a tree of triangles, as one stage.
template <class Make>
auto sort_triangles(Listener& listener, const Make& make) {
  return in_stage(listener, "sorting triangles", "triangles", make);
}

}  // namespace alidade::jobs
