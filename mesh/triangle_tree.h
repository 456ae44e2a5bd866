// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "base/bounds.h"
#include "base/surfaces.h"
#include "mesh/triangle_mesh.h"

namespace alidade {

/// Where a ray meets a triangle.
struct TriangleHit {
  double t = 0.0;                     ///< distance along the ray, metres
  std::uint32_t triangle = 0;         ///< number in the mesh
  TriangleMesh::Triangle vertices{};  ///< of the triangle
  std::array<double, 3> weights{};    ///< of its vertices, which sum to 1 (barycentric coordinates)
  glm::dvec3 normal{0.0, 0.0, 1.0};   ///< unit vector, on the side that the ray comes from

  bool operator==(const TriangleHit&) const = default;
};

/// Returns whether a hit counts. Called from many threads at once; must return the same for equal hits.
using TriangleFilter = std::function<bool(const TriangleHit&)>;

/// Finds the triangles of a mesh that rays meet, from either side. Safe to use from many threads.
///
/// The answer is that of a loop over all triangles, bit for bit: least t first, then least number. Edges
/// and vertices belong to all their triangles, so that no ray passes between two adjacent ones.
/// Triangles are tested in coordinates relative to the middle of the mesh, so that t is correct to 1e-8 m
/// also with projected coordinates.
class TriangleTree final : public Surfaces {
 public:
  /// Builds the tree, the same with any number of threads. `progress` counts triangles. Requires at least one
  /// triangle, and triangles whose vertices exist. Errors: Cancelled. Memory: 28 bytes per triangle, and 40
  /// more while it is built. Cost: 0.5 microseconds of one thread per triangle.
  explicit TriangleTree(TriangleMesh mesh, const Progress& progress = {});

  /// The first hit with t_min <= t <= t_max that counts; without `counts`, all do. Cost: some microseconds
  /// for a million triangles.
  std::optional<TriangleHit> closest(const Ray& ray, const TriangleFilter& counts = {}) const;
  /// Whether there is such a hit. Faster than closest().
  bool occluded(const Ray& ray, const TriangleFilter& counts) const;

  std::optional<Hit> nearest(const Ray& ray) const override;
  bool occluded(const Ray& ray) const override { return occluded(ray, {}); }
  const Bounds& bounds() const override { return bounds_; }

  /// Whether `triangle` accepts the vertices of any triangle. Skips the triangles in boxes that `box`
  /// rejects: it must accept all boxes of triangles that `triangle` accepts. Both get world coordinates.
  bool any(const std::function<bool(const Bounds&)>& box,
           const std::function<bool(const std::array<glm::dvec3, 3>&)>& triangle) const;

  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(triangles_.size()); }

  /// Linear colour at a hit; empty if the mesh has none.
  std::optional<Rgb> color(const TriangleHit& hit) const;

 private:
  /// The boxes of both halves of a range of blocks, which are runs of some triangles. Relative to middle_,
  /// rounded outward.
  struct Node {
    std::array<std::array<glm::vec3, 2>, 2> boxes;
  };
  class Walk;
  class Build;

  // A slot is the index of a triangle in the order of the tree.
  Walk walk_of(const Ray& ray) const;
  std::optional<TriangleHit> meet(const Walk& walk, std::uint32_t slot) const;
  std::optional<TriangleHit> meet(const Walk& walk, std::uint32_t slot, const Ray& ray,
                                  const TriangleFilter& counts) const;
  TriangleHit finished(const Ray& ray, TriangleHit hit) const;
  template <class Visit>
  void for_slots(Walk& walk, const Visit& visit) const;

  glm::dvec3 middle_{0.0};  ///< of the mesh, world
  double slack_ = 0.0;      ///< margin of the boxes of triangles, metres
  Bounds bounds_;
  std::vector<glm::dvec3> vertices_;               ///< relative to middle_
  std::vector<TriangleMesh::Triangle> triangles_;  ///< in the order of the tree
  std::vector<std::uint32_t> numbers_;             ///< in the mesh, by slot
  std::vector<Node> nodes_;                        ///< by the first block of their second half
  std::vector<Rgb> vertex_colors_, triangle_colors_;
};

}  // namespace alidade
