// SPDX-License-Identifier: MIT
#include <cstdint>
#include <cstdlib>
#include <span>

#include "base/error.h"
#include "mesh/mesh_files.h"

/// Any bytes through both readers: an Error, or triangles of vertices that exist, no more than the bytes can
/// name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  for (const auto read : {read_ply_mesh, read_obj_mesh}) {
    try {
      InputFile file(std::as_bytes(std::span(data, size)), "input");
      std::uint64_t left_out = 0;
      const TriangleMesh mesh = read(file, left_out, {});
      if (mesh.vertices.size() > size || mesh.triangles.size() > size) std::abort();
      for (const TriangleMesh::Triangle& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle)
          if (vertex >= mesh.vertices.size()) std::abort();
      if (!mesh.vertex_colors.empty() && mesh.vertex_colors.size() != mesh.vertices.size()) std::abort();
      if (!mesh.triangle_colors.empty() && mesh.triangle_colors.size() != mesh.triangles.size()) std::abort();
    } catch (const Error&) {
    }
  }
  return 0;
}
