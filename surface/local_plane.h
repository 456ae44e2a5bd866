// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "octree/octree.h"

namespace alidade {

namespace simd {
struct Moments;
}

/// The surface that the points around a position lie on.
struct LocalPlane {
  glm::dvec3 normal{0.0, 0.0, 1.0};  ///< unit; which of the two sides is not defined
  double trust = 0.0;                ///< 0: no surface here (foliage, lone points) .. 1: a plane
  double height = 0.0;               ///< of the position above the plane, along the normal, metres
  double thickness = 0.0;            ///< standard deviation of the points from the plane, metres
  /// Distance of the points' mean from the position along the plane, metres: small in the midst of a surface.
  double off_center = 0.0;
  double count = 0.0;  ///< of the points
};

/// A plane is a surface from this trust on.
constexpr double k_least_surface_trust = 0.7;

/// Two directions in a plane, of length 1 and at right angles.
struct PlaneAxes {
  glm::dvec3 first, second;
};

/// Those in the plane across a unit normal.
inline PlaneAxes axes_across(const glm::dvec3& normal) {
  const glm::dvec3 across =
      std::fabs(normal.z) < 0.7 ? glm::dvec3(normal.y, -normal.x, 0.0) : glm::dvec3(0.0, normal.z, -normal.y);
  const glm::dvec3 first = glm::normalize(across);
  return {first, glm::cross(normal, first)};
}

/// Fits a plane to the points within `reach` metres of a position, nearer ones weighing more. Requires
/// reach > 0. The same bits on every instruction set. Cost: 1 to 10 microseconds, grows with the number of
/// points. Source: Hoppe et al., Surface Reconstruction from Unorganized Points, 1992.
LocalPlane local_plane(const Octree& octree, const glm::dvec3& position, double reach);

/// local_plane() of some of those points, from their sums.
LocalPlane plane_of(const simd::Moments& moments, double reach);

}  // namespace alidade
