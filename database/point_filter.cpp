// SPDX-License-Identifier: MIT
#include "database/point_filter.h"

#include <algorithm>

#include "octree/distance.h"

namespace alidade::database {
namespace {

bool meets(const Interval& limits, double value) {
  return limits.low <= value && value <= limits.high;
}

/// Ends that overflowed to NaN rule nothing out.
bool meets(const Interval& limits, const Interval& reach) {
  return limits.low <= limits.high && !(reach.high < limits.low) && !(reach.low > limits.high);
}

/// The conditions on distances, of a point or of those in a box.
template <class Position>
bool meets_distances(const PointFilter& filter, const Position& position) {
  const auto meets_line = [&](const LineCondition& line) {
    const auto at = project(line.ray, position);
    return meets(line.distance, at.distance) && meets(line.t, at.t);
  };
  const auto meets_plane = [&](const PlaneCondition& plane) {
    return meets(plane.distance, signed_distance(plane.plane, position));
  };
  return std::ranges::all_of(filter.lines, meets_line) && std::ranges::all_of(filter.planes, meets_plane);
}

}  // namespace

bool holds(const PointFilter& filter, const glm::dvec3& point) {
  return filter.box.contains(point) && meets_distances(filter, point);
}

bool may_hold(const PointFilter& filter, const Bounds& box) {
  return meet(filter.box, box) && meets_distances(filter, box);
}

}  // namespace alidade::database
