// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "base/input_file.h"
#include "mesh/triangle_mesh.h"

// The formats of read_mesh().

namespace alidade {

/// Triangles of a PLY file in the file's coordinates; counts those left out. Errors: as read_mesh().
TriangleMesh read_ply_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress);

/// Triangles of an OBJ file in the file's coordinates. Its MTL files are in its directory; a missing one is a
/// warning. Errors: as read_mesh().
TriangleMesh read_obj_mesh(InputFile& file, std::uint64_t& left_out, const Progress& progress);

}  // namespace alidade
