// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

namespace alidade {

/// Axis-parallel box in world coordinates, both faces inclusive. The empty box is inverted (min > max).
struct Bounds {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};

  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }

  void grow(const glm::dvec3& point) {
    for (int axis = 0; axis < 3; ++axis) {
      min[axis] = std::min(min[axis], point[axis]);
      max[axis] = std::max(max[axis], point[axis]);
    }
  }

  void grow(const Bounds& other) {
    if (other.empty()) return;
    grow(other.min);
    grow(other.max);
  }

  bool contains(const glm::dvec3& point) const {
    return point.x >= min.x && point.x <= max.x && point.y >= min.y && point.y <= max.y && point.z >= min.z &&
           point.z <= max.z;
  }

  /// Side lengths; zero for the empty box.
  glm::dvec3 size() const { return empty() ? glm::dvec3(0) : max - min; }
  glm::dvec3 center() const { return 0.5 * (min + max); }
};

/// The eight corners of a box that is not empty: bits 0 to 2 of the index choose the maximum of x, y and z.
inline std::array<glm::dvec3, 8> corners(const Bounds& bounds) {
  std::array<glm::dvec3, 8> all;
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = {(i & 1 ? bounds.max : bounds.min).x, (i & 2 ? bounds.max : bounds.min).y,
              (i & 4 ? bounds.max : bounds.min).z};
  return all;
}

/// The smallest box around both.
inline Bounds joined(Bounds a, const Bounds& b) {
  a.grow(b);
  return a;
}

/// Distance from a position to a box that is not empty, 0 inside.
inline double distance_to(const Bounds& box, const glm::dvec3& position) {
  return glm::distance(position, glm::clamp(position, box.min, box.max));
}

/// Whether two boxes have a point in common, faces included. False if one is empty or a face is not a
/// number.
inline bool meet(const Bounds& a, const Bounds& b) {
  return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
         a.min.z <= b.max.z && b.min.z <= a.max.z;
}

}  // namespace alidade
