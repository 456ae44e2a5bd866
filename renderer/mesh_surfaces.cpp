// SPDX-License-Identifier: MIT
#include "renderer/mesh_surfaces.h"

#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "base/fingerprint.h"

namespace alidade::renderer {
namespace {

/// Of a mesh without colours.
constexpr Rgb k_grey{0.5f};

std::string name_with_checksum(const TriangleMesh& mesh, const std::string& name) {
  std::vector<std::uint64_t> sums;
  append_checksums(
      {std::as_bytes(std::span(mesh.vertices)), std::as_bytes(std::span(mesh.triangles)),
       std::as_bytes(std::span(mesh.vertex_colors)), std::as_bytes(std::span(mesh.triangle_colors))},
      sums);
  return fmt::format("{} {:016x}", name, checksum(std::as_bytes(std::span(sums))));
}

}  // namespace

MeshSurfaces::MeshSurfaces(TriangleMesh mesh, std::string name, const Progress& progress)
    : name_(name_with_checksum(mesh, name)), tree_(std::move(mesh), progress) {}

std::optional<Surfaces::Hit> MeshSurfaces::closest(const Ray& ray) const {
  const std::optional<TriangleHit> hit = tree_.closest(ray);
  if (!hit) return std::nullopt;
  return Hit{.t = hit->t, .normal = hit->normal, .color = tree_.color(*hit).value_or(k_grey)};
}

void load_mesh(Model& model, std::vector<std::string>& warnings, const Progress& reading,
               const Progress& building) {
  const MeshFile& source = *model.mesh;
  TriangleMesh mesh = read_mesh(source.file, source.placement, reading);
  warnings.insert(warnings.end(), mesh.warnings.begin(), mesh.warnings.end());
  model.surfaces = std::make_shared<MeshSurfaces>(std::move(mesh), source.file.string(), building);
}

}  // namespace alidade::renderer
