// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "octree/distance.h"
#include "octree/path_index.h"
#include "octree/query.h"

// How one point is decided, shared by brute force and index: whatever an index discards beforehand, what is
// left goes through these functions, so answers are the same bits. One `evaluate` per family of targets: the
// point as an answer if it meets every condition of the query, the filter called last. Requires: target and
// query checked (octree/check_query.h).

namespace alidade {

/// Which functions of a filter are called.
enum class Filters { all, of_position };

/// The answer if the filter admits it. query_index: number of the target in a batch; radius, disc: of the
/// point.
template <class Query, class Answer>
std::optional<Answer> admitted(const Query& query, const Answer& answer, std::size_t query_index,
                               double radius = 0.0, const PointDisc* disc = nullptr,
                               Filters filters = Filters::all) {
  const CandidateFilter& filter = query.filter;
  if (!filter) return answer;
  Candidate candidate{.point_id = answer.point_id,
                      .position = answer.position,
                      .distance = answer.distance,
                      .radius = radius,
                      .disc = disc,
                      .query_index = query_index};
  if constexpr (requires { answer.t; }) candidate.t = answer.t;
  const bool is_admitted = filters == Filters::all ? filter.admits(candidate)
                                                   : !filter.of_position || filter.of_position(candidate);
  return is_admitted ? std::optional(answer) : std::nullopt;
}

/// For a point with this radius. Query: RayQuery, or another with its entry_min and filter.
template <class Query>
std::optional<Hit> evaluate(const Ray& ray, const Query& query, double radius, const glm::dvec3& position,
                            std::uint64_t point_id, std::size_t query_index, Filters filters = Filters::all) {
  const RayProjection projection = project(ray, position);
  if (!(projection.distance <= radius && projection.t >= ray.t_min && projection.t <= ray.t_max)) {
    return std::nullopt;
  }
  const double entered_at = entry(projection, radius);
  if (!(entered_at >= query.entry_min)) return std::nullopt;
  const Hit hit{point_id, position, projection.t, projection.distance, entered_at};
  return admitted(query, hit, query_index, radius, nullptr, filters);
}

/// For points that share the query's radius.
inline std::optional<Hit> evaluate(const Ray& ray, const RayQuery& query, const glm::dvec3& position,
                                   std::uint64_t point_id, std::size_t query_index = 0) {
  return evaluate(ray, query, query.radius, position, point_id, query_index);
}

inline std::optional<Hit> evaluate(const Cone& cone, const ConeQuery& query, const glm::dvec3& position,
                                   std::uint64_t point_id, std::size_t query_index = 0) {
  const RayProjection projection = project(cone.axis, position);
  const double limit = cone.limit(projection.t);
  if (!(projection.distance <= limit && projection.t >= cone.axis.t_min && projection.t <= cone.axis.t_max)) {
    return std::nullopt;
  }
  const double entered_at = entry(projection, limit);
  if (std::isnan(entered_at)) return std::nullopt;
  const Hit hit{point_id, position, projection.t, projection.distance, entered_at};
  return admitted(query, hit, query_index);
}

/// t_min, t_max: the path's. projection: of the point on the path.
inline std::optional<PathHit> evaluate(const PathProjection& projection, double t_min, double t_max,
                                       const PathQuery& query, const glm::dvec3& position,
                                       std::uint64_t point_id, std::size_t query_index = 0) {
  if (!(projection.distance <= query.radius && projection.t >= t_min && projection.t <= t_max)) {
    return std::nullopt;
  }
  const PathHit hit{point_id, position, projection.segment, projection.t, projection.distance};
  return admitted(query, hit, query_index);
}

inline std::optional<PointHit> evaluate(const HalfSpaces& region, const PointQuery& query,
                                        const glm::dvec3& position, std::uint64_t point_id,
                                        std::size_t query_index = 0) {
  PointHit hit{point_id, position, 0.0};
  for (std::size_t i = 0; i < region.planes.size(); ++i) {
    const double side = signed_distance(region.planes[i], position);
    if (!(side >= 0.0)) return std::nullopt;
    if (i == 0) hit.distance = side;
  }
  return admitted(query, hit, query_index);
}

inline std::optional<PointHit> evaluate(const Bounds& box, const PointQuery& query,
                                        const glm::dvec3& position, std::uint64_t point_id,
                                        std::size_t query_index = 0) {
  if (!box.contains(position)) return std::nullopt;
  return admitted(query, PointHit{point_id, position, 0.0}, query_index);
}

inline std::optional<PointHit> evaluate(const glm::dvec3& point, const PointQuery& query,
                                        const glm::dvec3& position, std::uint64_t point_id,
                                        std::size_t query_index = 0) {
  const PointHit hit{point_id, position, distance(point, position)};
  return hit.distance <= query.radius ? admitted(query, hit, query_index) : std::nullopt;
}

/// The value a measure orders by.
inline double measured(Measure measure, const Hit& hit) {
  if (measure == Measure::distance) return hit.distance;
  return measure == Measure::t ? hit.t : hit.entry;
}

inline double measured(Measure measure, const PathHit& hit) {
  return measure == Measure::distance ? hit.distance : hit.t;
}

/// Points, boxes and half-spaces order by distance only.
inline double measured(Measure, const PointHit& hit) {
  return hit.distance;
}

/// Order of answers: by the measure, then by point id.
template <class Answer>
bool precedes(Measure measure, const Answer& a, const Answer& b) {
  const double value_a = measured(measure, a), value_b = measured(measure, b);
  return value_a < value_b || (value_a == value_b && a.point_id < b.point_id);
}

}  // namespace alidade
