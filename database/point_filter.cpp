// SPDX-License-Identifier: MIT
#include "database/point_filter.h"

#include <algorithm>

namespace alidade::database {
namespace {

bool meets(const Interval& limits, double value) {
  return limits.low <= value && value <= limits.high;
}

/// Ends that overflowed to NaN exclude nothing.
bool meets(const Interval& limits, const Interval& reach) {
  return limits.low <= limits.high && !(reach.high < limits.low) && !(reach.low > limits.high);
}

/// Whether the distances of a point, or of some point in a box, meet the conditions.
template <class PointOrBox>
bool meets_distances(const PointFilter& filter, const PointOrBox& where) {
  const auto meets_line = [&](const LineCondition& line) {
    const auto at = project(line.ray, where);
    return meets(line.distance, at.distance) && meets(line.t, at.t);
  };
  const auto meets_plane = [&](const PlaneCondition& plane) {
    return meets(plane.distance, signed_distance(plane.plane, where));
  };
  return std::ranges::all_of(filter.lines, meets_line) && std::ranges::all_of(filter.planes, meets_plane);
}

}  // namespace

void PointFilter::add(DistanceKind kind, const CloudLine& line, const Interval& distance) {
  if (kind == DistanceKind::ray)
    lines.push_back({.ray = {.origin = line.position, .direction = line.unit}, .distance = distance});
  else
    planes.push_back({.plane = {line.position, line.unit}, .distance = distance});
}

bool holds(const PointFilter& filter, const glm::dvec3& point) {
  return filter.box.contains(point) && meets_distances(filter, point);
}

bool may_hold(const PointFilter& filter, const Bounds& box) {
  return meet(filter.box, box) && meets_distances(filter, box);
}

}  // namespace alidade::database
