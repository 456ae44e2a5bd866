// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

#include "octree/build.h"
#include "octree/octree.h"
#include "tests/support/point_families.h"

// Surfaces whose horizon, sky and shade are known on paper, as dense points.

namespace alidade::test {

using Points = std::vector<glm::dvec3>;

/// A rectangle corner + a u + b v, u in [0, |u|], v in [0, |v|], a point about every `spacing` metres.
inline void add_rectangle(Points& points, const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v,
                          double spacing) {
  const int columns = static_cast<int>(std::ceil(glm::length(u) / spacing)),
            rows = static_cast<int>(std::ceil(glm::length(v) / spacing));
  for (int i = 0; i <= columns; ++i)
    for (int j = 0; j <= rows; ++j)
      points.push_back(corner + u * (static_cast<double>(i) / columns) + v * (static_cast<double>(j) / rows));
}

/// The mantle of an upright cone.
inline void add_cone(Points& points, const glm::dvec3& apex, double height, double base_radius,
                     double spacing) {
  const double slant = std::hypot(height, base_radius);
  const int rings = static_cast<int>(std::ceil(slant / spacing));
  points.push_back(apex);
  for (int ring = 1; ring <= rings; ++ring) {
    const double share = static_cast<double>(ring) / rings, radius = share * base_radius;
    const int count = static_cast<int>(std::ceil(2.0 * std::numbers::pi * radius / spacing)) + 3;
    for (int i = 0; i < count; ++i) {
      const double turn = 2.0 * std::numbers::pi * (i + 0.5 * (ring % 2)) / count;
      points.push_back(apex + glm::dvec3(radius * std::cos(turn), radius * std::sin(turn), -share * height));
    }
  }
}

/// A whole sphere, its points on a spiral.
inline void add_sphere(Points& points, const glm::dvec3& center, double radius, int count) {
  constexpr double k_golden_angle = 2.399963229728653;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (i + 0.5) / count, run = std::sqrt(1.0 - z * z);
    points.push_back(center + radius * glm::dvec3(run * std::cos(k_golden_angle * i),
                                                  run * std::sin(k_golden_angle * i), z));
  }
}

inline Octree octree_of(const Points& points) {
  Lattice lattice;
  lattice.scale = glm::dvec3(0.0001);
  return build(make_cloud(points, lattice));
}

}  // namespace alidade::test
