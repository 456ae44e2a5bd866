// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include "octree/octree.h"

namespace alidade {

/// The surface that the points around a place lie on.
struct LocalPlane {
  glm::dvec3 normal{0.0, 0.0, 1.0};  ///< unit; which of the two sides is not told
  double trust = 0.0;                ///< 0: no surface here (foliage, lone points) .. 1: a plane
};

/// Fits a plane to the points within `reach` metres of a place, nearer ones weighing more. Requires reach >
/// 0. The same bits on every instruction set. Cost: 1 to 10 microseconds, grows with the number of points.
/// Source: Hoppe et al., Surface Reconstruction from Unorganized Points, 1992.
LocalPlane local_plane(const Octree& octree, const glm::dvec3& place, double reach);

}  // namespace alidade
