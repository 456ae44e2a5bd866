// SPDX-License-Identifier: MIT
#include "database/point_filter.h"

#include <algorithm>

#include "base/bounds.h"
#include "octree/distance.h"

namespace alidade::database {
namespace {

bool contains(const Interval& limits, double value) {
  return limits.low <= value && value <= limits.high;
}

/// Ends that overflowed to NaN rule nothing out.
bool may_meet(const Interval& limits, const Interval& reach) {
  return limits.low <= limits.high && !(reach.high < limits.low) && !(reach.low > limits.high);
}

}  // namespace

bool holds(const PointFilter& filter, const glm::dvec3& point) {
  return filter.box.contains(point) &&
         std::ranges::all_of(filter.lines,
                             [&](const LineCondition& line) {
                               const RayProjection at = project(line.ray, point);
                               return contains(line.distance, at.distance) && contains(line.t, at.t);
                             }) &&
         std::ranges::all_of(filter.planes, [&](const PlaneCondition& plane) {
           return contains(plane.distance, signed_distance(plane.plane, point));
         });
}

bool may_hold(const PointFilter& filter, const Bounds& box) {
  return meet(filter.box, box) &&
         std::ranges::all_of(filter.lines,
                             [&](const LineCondition& line) {
                               const RayReach reach = project(line.ray, box);
                               return may_meet(line.distance, reach.distance) && may_meet(line.t, reach.t);
                             }) &&
         std::ranges::all_of(filter.planes, [&](const PlaneCondition& plane) {
           return may_meet(plane.distance, signed_distance(plane.plane, box));
         });
}

}  // namespace alidade::database
