// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "base/ray_slabs.h"
#include "mesh/triangle_tree.h"

// TriangleTree::closest() by a loop over all triangles: the definition of its answers, bit for bit.

namespace alidade::test {

/// A vertex in coordinates along a ray from `origin`: x and y across it, z in units of t.
class Shear {
 public:
  Shear(const glm::dvec3& origin, const glm::dvec3& direction) : origin_(origin) {
    for (int axis = 0; axis < 3; ++axis)
      if (std::fabs(direction[axis]) > std::fabs(direction[z_])) z_ = axis;
    x_ = (z_ + 1) % 3;
    y_ = (x_ + 1) % 3;
    shear_ = glm::dvec3(direction[x_], direction[y_], 1.0) / direction[z_];
  }

  glm::dvec3 operator()(const glm::dvec3& vertex) const {
    const glm::dvec3 offset = vertex - origin_;
    return {offset[x_] - shear_.x * offset[z_], offset[y_] - shear_.y * offset[z_], shear_.z * offset[z_]};
  }

 private:
  glm::dvec3 origin_, shear_{0.0};
  int x_ = 0, y_ = 0, z_ = 0;
};

inline std::optional<TriangleHit> closest_by_brute_force(const TriangleMesh& mesh, const Ray& ray,
                                                         const TriangleFilter& counts = {}) {
  Bounds bounds;
  for (const TriangleMesh::Triangle& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle) bounds.grow(mesh.vertices[vertex]);
  const glm::dvec3 middle = bounds.center(), origin = ray.origin - middle;
  const double slack = 0x1p-40 * length_of(bounds.size());
  const RaySlabs slabs(origin, ray.direction);
  const Shear sheared(origin, ray.direction);
  std::optional<TriangleHit> best;
  for (std::uint32_t number = 0; number < mesh.triangles.size(); ++number) {
    const TriangleMesh::Triangle& triangle = mesh.triangles[number];
    const glm::dvec3 a = mesh.vertices[triangle[0]] - middle, b = mesh.vertices[triangle[1]] - middle,
                     c = mesh.vertices[triangle[2]] - middle;
    const glm::dvec3 from_a = sheared(a), from_b = sheared(b), from_c = sheared(c);
    const double u = from_c.x * from_b.y - from_c.y * from_b.x, v = from_a.x * from_c.y - from_a.y * from_c.x,
                 w = from_b.x * from_a.y - from_b.y * from_a.x, sum = u + v + w;
    if (((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) || sum == 0.0) continue;
    TriangleHit hit{.triangle = number, .vertices = triangle, .weights = {u / sum, v / sum, w / sum}};
    const glm::dvec3 low = glm::min(a, glm::min(b, c)) - slack, high = glm::max(a, glm::max(b, c)) + slack;
    Stretch stretch;
    for (int axis = 0; axis < 3; ++axis) stretch.cut(slabs.between(axis, low[axis], high[axis]));
    const double t = hit.weights[0] * from_a.z + hit.weights[1] * from_b.z + hit.weights[2] * from_c.z;
    hit.t = std::min(std::max(t, stretch.begin), stretch.end);
    if (stretch.empty() || !(hit.t >= ray.t_min && hit.t <= ray.t_max)) continue;
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    hit.normal = normal == glm::dvec3(0.0) ? -ray.direction : unit_direction(normal);
    if (glm::dot(hit.normal, ray.direction) > 0.0) hit.normal = -hit.normal;
    if (counts && !counts(hit)) continue;
    if (!best || std::pair(hit.t, number) < std::pair(best->t, best->triangle)) best = hit;
  }
  return best;
}

}  // namespace alidade::test
