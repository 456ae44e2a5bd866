// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "base/bounds.h"
#include "base/interval.h"
#include "base/ray.h"
#include "cloud/point_cloud.h"
#include "octree/distance.h"
#include "octree/targets.h"

namespace alidade::database {

/// Some points of a cloud in a database, ordered by their ids.
struct CloudPart {
  PointCloud cloud;
  std::vector<std::uint64_t> ids;  ///< of each row its number in the whole cloud
  AttributeSet attributes{};       ///< of the whole cloud
  std::uint64_t chunks_read = 0, chunk_count = 0;
};

enum class DistanceKind : std::int64_t { ray = 1, plane = 2 };

/// The ray of dist_ray, or the plane of dist_plane with its normal; in PostgreSQL the values of the types
/// cloud_ray and cloud_plane, byte for byte. The given numbers are stored beside the unit vector, so that the
/// text of a value is read as the same value.
struct CloudLine {
  glm::dvec3 position, direction;
  glm::dvec3 unit;  ///< direction with length 1
};

/// Errors: as make_ray() and make_plane().
inline CloudLine make_line(DistanceKind kind, const glm::dvec3& position, const glm::dvec3& direction) {
  const glm::dvec3 unit = kind == DistanceKind::ray ? make_ray(position, direction).direction
                                                    : make_plane(position, direction).normal;
  return {position, direction, unit};
}

/// dist_ray or dist_plane of a point, or its interval over the points of a box. If the distance of any of
/// these is NaN, an end is NaN or high is infinite.
template <class PointOrBox>
auto distance(DistanceKind kind, const CloudLine& line, const PointOrBox& where) {
  if (kind == DistanceKind::ray)
    return project(Ray{.origin = line.position, .direction = line.unit}, where).distance;
  return signed_distance(Plane{line.position, line.unit}, where);
}

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

  /// Adds the condition that dist_ray or dist_plane is in an interval.
  void add(DistanceKind kind, const CloudLine& line, const Interval& distance);
};

/// Whether a filter holds for a point. Requires finite coordinates.
bool holds(const PointFilter& filter, const glm::dvec3& point);

/// False only if a filter holds for no point of the box, to the last bit: the paper's pruning of chunks by
/// bounds of a distance over their boxes (section 4.2), with the bounds of base/interval.h.
bool may_hold(const PointFilter& filter, const Bounds& box);

}  // namespace alidade::database
