// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "base/bounds.h"
#include "base/interval.h"
#include "base/ray.h"
#include "cloud/point_cloud.h"
#include "octree/targets.h"

namespace alidade::database {

/// Some points of a cloud in a database, ordered by their ids.
struct CloudPart {
  PointCloud cloud;
  std::vector<std::uint64_t> ids;  ///< of each row its number in the whole cloud
  AttributeSet attributes{};       ///< of the whole cloud
  std::uint64_t chunks_read = 0, chunk_count = 0;
};

/// dist_ray and t of a point (octree/distance.h: project), each in a closed interval.
struct LineCondition {
  Ray ray;
  Interval distance{};
  Interval t{};
};

/// dist_plane of a point (octree/distance.h: signed_distance) in a closed interval.
struct PlaneCondition {
  Plane plane;
  Interval distance{};
};

/// The conditions of a WHERE clause that can be tested on chunks of points. All of them must hold. No point
/// is within a limit that is NaN.
struct PointFilter {
  std::vector<LineCondition> lines{};
  std::vector<PlaneCondition> planes{};
  /// Coordinates, faces inclusive.
  Bounds box{glm::dvec3(-std::numeric_limits<double>::infinity()),
             glm::dvec3(std::numeric_limits<double>::infinity())};
};

/// Whether a filter holds for a point. Requires finite coordinates.
bool holds(const PointFilter& filter, const glm::dvec3& point);

/// False only if a filter holds for no point of the box, to the last bit: the paper's pruning of chunks by
/// bounds of a distance over their boxes (section 4.2), with the bounds of base/interval.h.
bool may_hold(const PointFilter& filter, const Bounds& box);

}  // namespace alidade::database
