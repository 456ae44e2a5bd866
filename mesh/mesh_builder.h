// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "base/input_file.h"
#include "mesh/triangle_mesh.h"

// Functions for the readers of meshes.

namespace alidade {

/// Most vertices and triangles of a mesh.
inline constexpr std::uint64_t k_most_mesh_parts = std::numeric_limits<std::uint32_t>::max();

/// Errors: less than `byte_count` of memory is free. Not checked if the system does
/// not report its free memory.
void check_free_memory(const std::string& file, std::uint64_t byte_count);

/// Adds a polygon as a fan of triangles. Triangles with a vertex twice, and polygons of one or two vertices,
/// are not added but counted in `left_out`. Requires: the vertices exist. Errors: more than
/// k_most_mesh_parts triangles.
void add_fan(const std::string& file, std::span<const std::uint32_t> polygon, TriangleMesh& mesh,
             std::uint64_t& left_out);

/// Triangles of a PLY file in the file's coordinates. Errors: as read_mesh().
TriangleMesh read_ply_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress);

/// Triangles of an OBJ file in the file's coordinates. Its MTL files are in its directory; a missing one is a
/// warning. Errors: as read_mesh().
TriangleMesh read_obj_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress);

}  // namespace alidade
