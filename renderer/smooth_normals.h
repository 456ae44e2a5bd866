// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "octree/local_plane.h"
#include "octree/octree.h"

namespace alidade {

/// Normals for `"normals": "smooth"`: of a plane through all points within a reach, nearer ones weighing
/// more. Each is worked out when it is first asked for and kept (4 bytes per point), so a picture pays for
/// what it shows. The answer is a function of the cloud alone: safe and equal from any number of threads.
class SmoothNormals {
 public:
  /// The octree must outlive this.
  explicit SmoothNormals(const Octree& octree);

  /// For the point with this id, which lies at `position`. reach: always the same for the same point.
  LocalPlane at(std::uint64_t point_id, const glm::dvec3& position, double reach) const;

 private:
  const Octree* octree_;
  mutable std::vector<std::atomic<std::uint32_t>> kept_;  ///< packed; 0 = not asked for yet
};

}  // namespace alidade
