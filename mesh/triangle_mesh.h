// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "base/color.h"
#include "base/progress.h"

// Triangles from files of other programs: planned buildings, terrain models.

namespace alidade {

/// Triangles and their colours.
struct TriangleMesh {
  /// Indices of three vertices.
  using Triangle = std::array<std::uint32_t, 3>;

  std::vector<glm::dvec3> vertices;  ///< finite
  std::vector<Triangle> triangles;
  std::vector<Rgb> vertex_colors;    ///< linear, 0 to 1; as many as vertices, or none
  std::vector<Rgb> triangle_colors;  ///< as many as triangles, or none; used instead of those of vertices
  std::vector<std::string> warnings;
};

/// Checksum of vertices, triangles and colours.
std::uint64_t checksum(const TriangleMesh& mesh);

/// Placement of a mesh in the world: scaled about the origin of its file, rotated about
/// that origin, then translated.
struct MeshPlacement {
  double scale = 1.0;         ///< (0, 1e12]
  double rotate_z = 0.0;      ///< degrees counterclockwise from above, [-360, 360]
  glm::dvec3 translate{0.0};  ///< world

  bool operator==(const MeshPlacement&) const = default;
};

/// Errors: the name does not have the extension of a mesh.
void check_mesh_name(const std::filesystem::path& file);

/// Reads PLY (ascii and binary, faces with `vertex_indices` or `vertex_index`) or OBJ (v, f, and the diffuse
/// colours Kd of its MTL files), by the name's extension. Polygons become fans around their first vertex, so
/// they must be convex. Colours of vertices and of PLY faces are sRGB, Kd is linear. Vertices are doubles, in
/// the file's coordinates times `placement`.
///
/// Triangles without area are left out, and counted in a warning. `progress` is in bytes. Errors: unknown
/// extension; malformed or truncated file; no triangles; a vertex that is not finite or further than 1e12
/// from the origin; indices of vertices that do not exist; more than 2^32 - 1 vertices or triangles; not
/// enough memory. Memory: 24 B per vertex and 12 B per triangle, and 12 B for each colour.
TriangleMesh read_mesh(const std::filesystem::path& file, const MeshPlacement& placement = {},
                       const Progress& progress = {});

}  // namespace alidade
