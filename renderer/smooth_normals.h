// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "octree/octree.h"

namespace alidade {

/// Normal of the surface that a point and its neighbours lie on.
struct SmoothNormal {
  glm::dvec3 normal{0.0, 0.0, 1.0};  ///< unit; which of the two sides is not told
  double trust = 0.0;                ///< 0: no surface here (foliage, lone points) .. 1: a plane
};

/// Normals for `"normals": "smooth"`: of a plane through all points within a reach, nearer ones weighing
/// more. Each is worked out when it is first asked for and kept (4 bytes per point), so a picture pays for
/// what it shows. The answer is a function of the cloud alone: safe and equal from any number of threads.
/// Source of the fit: Hoppe et al., Surface Reconstruction from Unorganized Points, 1992.
class SmoothNormals {
 public:
  /// The octree must outlive this.
  explicit SmoothNormals(const Octree& octree);

  /// For the point with this id, which lies at `position`. reach: always the same for the same point.
  SmoothNormal at(std::uint64_t point_id, const glm::dvec3& position, double reach) const;

 private:
  const Octree* octree_;
  mutable std::vector<std::atomic<std::uint32_t>> kept_;  ///< packed; 0 = not asked for yet
};

}  // namespace alidade
