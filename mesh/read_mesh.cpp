// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/exact_math.h"
#include "base/fingerprint.h"
#include "base/ray.h"
#include "base/words.h"
#include "mesh/mesh_builder.h"

namespace alidade {
namespace {

constexpr double k_largest_coordinate = 1e12;

/// Bytes of free memory; empty if the system does not report it.
std::optional<std::uint64_t> free_memory() {
  std::ifstream file("/proc/meminfo");
  std::string word;
  while (file >> word) {
    std::uint64_t kibibytes = 0;
    if (word == "MemAvailable:" && file >> kibibytes) return kibibytes * 1024;
  }
  return std::nullopt;
}

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

void check_free_memory(const std::string& file, std::uint64_t byte_count) {
  const std::optional<std::uint64_t> free = free_memory();
  if (!free || byte_count <= *free) return;
  const auto text = [](std::uint64_t bytes) {
    return fmt::format("{:.1f} GB", static_cast<double>(bytes) / 1e9);
  };
  throw file_error(file, "too little memory for this mesh", text(byte_count), text(*free) + " free");
}

void add_fan(const std::string& file, std::span<const std::uint32_t> polygon, TriangleMesh& mesh,
             std::uint64_t& left_out) {
  if (polygon.size() < 3) ++left_out;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    if (mesh.triangles.size() >= k_most_mesh_parts)
      throw file_error(file, "too many triangles", fmt::format("at most {}", k_most_mesh_parts));
    const TriangleMesh::Triangle triangle{polygon[0], polygon[i - 1], polygon[i]};
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[0] == triangle[2])
      ++left_out;
    else
      mesh.triangles.push_back(triangle);
  }
}

std::uint64_t checksum(const TriangleMesh& mesh) {
  std::vector<std::uint64_t> sums;
  append_checksums(
      {std::as_bytes(std::span(mesh.vertices)), std::as_bytes(std::span(mesh.triangles)),
       std::as_bytes(std::span(mesh.vertex_colors)), std::as_bytes(std::span(mesh.triangle_colors))},
      sums);
  return checksum(std::as_bytes(std::span(sums)));
}

TriangleMesh read_mesh(const std::filesystem::path& file, const MeshPlacement& placement,
                       const Progress& progress) {
  const bool is_ply = has_extension(file, {".ply"});
  if (!is_ply && !has_extension(file, {".obj"}))
    throw file_error(file, "unknown mesh format", "the extension .ply or .obj");
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
