// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "base/ray.h"
#include "cloud/lattice.h"
#include "octree/octree.h"

namespace alidade::simd {

/// The line of a ray as seen from the corner of the octree's root, so that origins far away cost no
/// precision.
struct LineFromRoot {
  double origin[3];  ///< foot of the perpendicular from the root's corner
  double direction[3];
  double shift = 0.0;  ///< t of that foot
  /// Exceeds the error of all this, and that of the formulas of octree/distance.h for points of the tree.
  double error = 0.0;
  double away = 0.0;  ///< an upper limit of the perpendicular's length

  /// Requires a direction of length 1 within 2e-15 (a rounding of its square).
  LineFromRoot(const TreeView& tree, const Ray& ray) {
    const glm::dvec3 corner = to_world(tree.lattice, tree.base);
    double largest = 0.0, way = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = ray.origin[axis] - corner[axis];
      direction[axis] = ray.direction[axis];
      shift -= origin[axis] * direction[axis];
      largest = std::max({largest, std::fabs(ray.origin[axis]), std::fabs(corner[axis]),
                          std::fabs(tree.bounds.max[axis]), std::fabs(tree.lattice.offset[axis])});
      way += std::fabs(origin[axis]) + (tree.bounds.max[axis] - corner[axis]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] += shift * direction[axis];
      away += std::fabs(origin[axis]);
    }
    error = 0x1p-48 * (largest + way) + 1e-18;
  }
};

}  // namespace alidade::simd
