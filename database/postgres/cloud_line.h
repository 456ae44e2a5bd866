// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "octree/distance.h"

namespace alidade {

enum class DistanceKind : std::int64_t { ray = 1, plane = 2 };

/// What a distance is measured from: the line of dist_ray, or the plane of dist_plane with its normal. The
/// values of the SQL types cloud_ray and cloud_plane, byte for byte. Numbers as they were given are kept
/// beside what was made of them: as text they come back as the same value.
struct CloudLine {
  glm::dvec3 place, direction;
  glm::dvec3 unit;  ///< direction with length 1
};

/// Errors: as make_ray() and make_plane().
inline CloudLine make_line(DistanceKind kind, const glm::dvec3& place, const glm::dvec3& direction) {
  const glm::dvec3 unit =
      kind == DistanceKind::ray ? make_ray(place, direction).direction : make_plane(place, direction).normal;
  return {place, direction, unit};
}

/// dist_ray or dist_plane of a point.
inline double distance(DistanceKind kind, const CloudLine& line, const glm::dvec3& point) {
  if (kind == DistanceKind::ray)
    return project(Ray{.origin = line.place, .direction = line.unit}, point).distance;
  return signed_distance(Plane{line.place, line.unit}, point);
}

/// Between what it lies for the points of a box. Where a point's is NaN, an end is NaN or high is infinite.
inline Interval distance(DistanceKind kind, const CloudLine& line, const Bounds& box) {
  if (kind == DistanceKind::ray)
    return project(Ray{.origin = line.place, .direction = line.unit}, box).distance;
  return signed_distance(Plane{line.place, line.unit}, box);
}

}  // namespace alidade
