// SPDX-License-Identifier: MIT
#include "renderer/mesh_surfaces.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

namespace alidade::renderer {
namespace {

/// Of a mesh without colours.
constexpr Rgb k_grey{0.5f};

}  // namespace

MeshSurfaces::MeshSurfaces(TriangleMesh mesh, std::string name, const Progress& progress)
    : name_(fmt::format("{} {:016x}", name, checksum(mesh))), tree_(std::move(mesh), progress) {}

std::optional<Surfaces::Hit> MeshSurfaces::closest(const Ray& ray) const {
  const std::optional<TriangleHit> hit = tree_.closest(ray);
  if (!hit) return std::nullopt;
  return Hit{.t = hit->t, .normal = hit->normal, .color = tree_.color(*hit).value_or(k_grey)};
}

}  // namespace alidade::renderer
