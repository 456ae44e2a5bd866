// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "base/bounds.h"
#include "base/ray.h"
#include "mesh/triangle_mesh.h"

namespace alidade {

/// Where a ray meets a triangle.
struct TriangleHit {
  double t = 0.0;                     ///< along the ray, metres
  std::uint32_t triangle = 0;         ///< number in the mesh
  TriangleMesh::Triangle vertices{};  ///< of the triangle
  std::array<double, 3> weights{};    ///< of its vertices, which sum to 1 (barycentric coordinates)
  glm::dvec3 normal{0.0, 0.0, 1.0};   ///< of length 1, towards the side the ray came from

  bool operator==(const TriangleHit&) const = default;
};

/// Whether a hit counts. Called from many threads at once; must return the same for the same hit.
using TriangleFilter = std::function<bool(const TriangleHit&)>;

/// Finds the triangles of a mesh that rays meet, from both sides. Safe to use from many threads.
///
/// The answer is that of a loop over all triangles, bit for bit: least t first, then least number. Edges
/// and vertices belong to all their triangles, so that rays do not slip through between two of them.
/// Triangles are tested in coordinates relative to the middle of the mesh, so that t is correct to 1e-8 m
/// also with projected coordinates.
class TriangleTree {
 public:
  /// The tree does not depend on the number of threads. Memory: 28 B per triangle, 40
  /// B more while it is built. Cost: 0.5 microseconds of one thread per triangle. Requires: at least one
  /// triangle, and vertices that exist. `progress` is in triangles. Errors: Cancelled.
  explicit TriangleTree(TriangleMesh mesh, const Progress& progress = {});

  /// The first triangle with t_min <= t <= t_max that counts. Cost: some
  /// microseconds for a million triangles.
  std::optional<TriangleHit> closest(const Ray& ray, const TriangleFilter& counts = {}) const;
  /// Whether there is such a triangle: faster.
  bool occluded(const Ray& ray, const TriangleFilter& counts = {}) const;

  /// Whether `triangle` accepts the corners (world) of any triangle. Triangles in boxes (world) that `box`
  /// does not accept are skipped: it must accept every box with a triangle that `triangle` accepts.
  bool any(const std::function<bool(const Bounds&)>& box,
           const std::function<bool(const std::array<glm::dvec3, 3>&)>& triangle) const;

  const Bounds& bounds() const { return bounds_; }  ///< world
  std::uint32_t triangle_count() const { return static_cast<std::uint32_t>(triangles_.size()); }

  /// Linear colour at a hit; empty if the mesh has none.
  std::optional<Rgb> color(const TriangleHit& hit) const;

 private:
  /// The boxes of both halves of a range of blocks, from the middle, rounded outward.
  struct Node {
    std::array<std::array<glm::vec3, 2>, 2> boxes;
  };
  class Walk;
  class Build;

  Walk walk_of(const Ray& ray) const;
  std::optional<TriangleHit> meet(const Walk& walk, std::uint32_t slot) const;
  std::optional<TriangleHit> meet(const Walk& walk, std::uint32_t slot, const Ray& ray,
                                  const TriangleFilter& counts) const;
  TriangleHit finished(const Ray& ray, TriangleHit hit) const;
  template <class Visit>
  void for_blocks(Walk& walk, const Visit& visit) const;

  glm::dvec3 middle_{0.0};
  double slack_ = 0.0;  ///< margin of the boxes of triangles, metres
  Bounds bounds_;
  std::vector<glm::dvec3> vertices_;               ///< from the middle
  std::vector<TriangleMesh::Triangle> triangles_;  ///< in the order of the tree
  std::vector<std::uint32_t> numbers_;             ///< in the mesh, by slot
  std::vector<Node> nodes_;                        ///< by the block their second half begins with
  std::vector<Rgb> vertex_colors_, triangle_colors_;
};

}  // namespace alidade
