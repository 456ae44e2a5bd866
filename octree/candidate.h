// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>

#include "octree/distance.h"
#include "octree/hit.h"
#include "octree/query.h"

// How one point is decided, shared by brute force and index: whatever an index discards beforehand, what is
// left goes through these functions, so answers are the same bits.

namespace alidade {

/// Errors: radius negative, infinite or NaN; entry_min NaN.
inline void check(const RayQuery& query) {
  if (!(query.radius >= 0.0) || std::isinf(query.radius)) {
    throw Error({.problem = "radius of a ray query is out of range",
                 .expected = "a finite number >= 0",
                 .found = std::to_string(query.radius)});
  }
  if (std::isnan(query.entry_min)) throw Error({.problem = "entry_min of a ray query is not a number"});
}

/// The point as a hit if it fulfils every condition of the query.
inline std::optional<Hit> evaluate(const Ray& ray, const RayQuery& query, const glm::dvec3& position,
                                   std::uint64_t point_id) {
  const RayProjection projection = project(ray, position);
  if (!(projection.distance <= query.radius && projection.t >= ray.t_min && projection.t <= ray.t_max)) {
    return std::nullopt;
  }
  const double entry_place = entry(projection, query.radius);
  if (!(entry_place >= query.entry_min)) return std::nullopt;
  return Hit{point_id, position, projection.t, projection.distance, entry_place};
}

/// The value a measure orders by.
inline double measured(Measure measure, const Hit& hit) {
  return measure == Measure::t ? hit.t : hit.entry;
}

/// Order of hits: by the measure, then by point id.
inline bool precedes(Measure measure, const Hit& a, const Hit& b) {
  const double value_a = measured(measure, a), value_b = measured(measure, b);
  return value_a < value_b || (value_a == value_b && a.point_id < b.point_id);
}

}  // namespace alidade
