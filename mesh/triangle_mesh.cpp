// SPDX-License-Identifier: MIT
#include "mesh/triangle_mesh.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/exact_math.h"
#include "base/fingerprint.h"
#include "base/ray.h"
#include "base/words.h"
#include "mesh/mesh_files.h"

namespace alidade {
namespace {

constexpr double k_largest_coordinate = 1e12;

void place(const std::string& file, const MeshPlacement& placement, TriangleMesh& mesh) {
  const auto [sine, cosine] = sine_cosine_of_degrees(placement.rotate_z);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    glm::dvec3& vertex = mesh.vertices[i];
    if (!is_finite(vertex)) throw file_error(file, fmt::format("vertex {} is not finite", i));
    if (placement != MeshPlacement{}) {
      const glm::dvec3 scaled = placement.scale * vertex;
      vertex = placement.translate +
               glm::dvec3(cosine * scaled.x - sine * scaled.y, sine * scaled.x + cosine * scaled.y, scaled.z);
    }
    const double largest = std::max({std::fabs(vertex.x), std::fabs(vertex.y), std::fabs(vertex.z)});
    if (!(largest <= k_largest_coordinate))
      throw file_error(file, fmt::format("vertex {} is too far away", i), "coordinates up to 1e12",
                       fmt::format("{:g}", largest));
  }
}

/// False also if the square of twice the area underflows to 0.
bool has_area(const TriangleMesh& mesh, const TriangleMesh::Triangle& triangle) {
  const glm::dvec3& a = mesh.vertices[triangle[0]];
  const glm::dvec3 cross = glm::cross(mesh.vertices[triangle[1]] - a, mesh.vertices[triangle[2]] - a);
  return glm::dot(cross, cross) > 0.0;
}

std::uint64_t leave_out_lines(TriangleMesh& mesh) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!has_area(mesh, mesh.triangles[i])) continue;
    mesh.triangles[kept] = mesh.triangles[i];
    if (!mesh.triangle_colors.empty()) mesh.triangle_colors[kept] = mesh.triangle_colors[i];
    ++kept;
  }
  const std::uint64_t left_out = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  if (!mesh.triangle_colors.empty()) mesh.triangle_colors.resize(kept);
  return left_out;
}

}  // namespace

std::uint64_t checksum(const TriangleMesh& mesh) {
  std::vector<std::uint64_t> sums;
  append_checksums(
      {std::as_bytes(std::span(mesh.vertices)), std::as_bytes(std::span(mesh.triangles)),
       std::as_bytes(std::span(mesh.vertex_colors)), std::as_bytes(std::span(mesh.triangle_colors))},
      sums);
  return checksum(std::as_bytes(std::span(sums)));
}

void check_mesh_name(const std::filesystem::path& file) {
  if (!has_extension(file, {".ply", ".obj"}))
    throw file_error(file, "unknown mesh format", "the extension .ply or .obj");
}

TriangleMesh read_mesh(const std::filesystem::path& file, const MeshPlacement& placement,
                       const Progress& progress) {
  check_mesh_name(file);
  const bool is_ply = has_extension(file, {".ply"});
  InputFile input(file);
  std::uint64_t left_out = 0;
  TriangleMesh mesh =
      is_ply ? read_ply_mesh(input, left_out, progress) : read_obj_mesh(input, left_out, progress);
  place(input.name(), placement, mesh);
  left_out += leave_out_lines(mesh);
  if (mesh.triangles.empty())
    throw file_error(file, "no triangles", "faces with an area",
                     left_out > 0 ? fmt::format("{} without area", left_out) : "none");
  if (left_out > 0)
    mesh.warnings.push_back(fmt::format("{}: left out {} triangles without area", file.string(), left_out));
  report(progress, input.size(), input.size());
  return mesh;
}

}  // namespace alidade
