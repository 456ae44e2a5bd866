// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "base/input_file.h"
#include "mesh/triangle_mesh.h"

// What the readers of meshes share.

namespace alidade {

/// Most vertices and triangles of a mesh.
inline constexpr std::uint64_t k_most_mesh_parts = std::numeric_limits<std::uint32_t>::max();

/// Errors: so many bytes are more than the machine has free. Where the system does not say, nothing is
/// checked.
void check_free_memory(const std::string& file, std::uint64_t byte_count);

/// Adds the fan of a polygon. Triangles that name a vertex twice, and polygons of one or two vertices, are
/// counted in `left_out`. Requires: the vertices exist. Errors: more than k_most_mesh_parts triangles.
void add_fan(const std::string& file, std::span<const std::uint32_t> polygon, TriangleMesh& mesh,
             std::uint64_t& left_out);

/// Triangles of a PLY file in the file's coordinates. Errors: as read_mesh().
TriangleMesh read_ply_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress);

/// The same of an OBJ file; its MTL files lie beside it. A missing one is a warning.
TriangleMesh read_obj_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress);

}  // namespace alidade
