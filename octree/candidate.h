// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "octree/distance.h"
#include "octree/path_index.h"
#include "octree/point_disc.h"
#include "octree/query.h"

// How one point is decided, shared by brute force and index: whatever an index discards beforehand, what is
// left goes through these functions, so answers are the same bits. One `evaluate` per family of targets: the
// point as an answer if it meets every condition of the query, the filter called last. Requires: target and
// query checked (octree/check_query.h).

namespace alidade {

/// Which filters of a query are called.
enum class Filters { all, of_position };

/// The answer if the filters admit it. query_index: number of the target in a batch; radius, disc: of the
/// point.
template <class Query, class Answer>
std::optional<Answer> admitted(const Query& query, const Answer& answer, std::size_t query_index,
                               double radius = 0.0, const PointDisc* disc = nullptr,
                               Filters filters = Filters::all) {
  if (!has_filter(query)) return answer;
  Candidate candidate{.point_id = answer.point_id,
                      .position = answer.position,
                      .distance = answer.distance,
                      .radius = radius,
                      .disc = disc,
                      .query_index = query_index};
  if constexpr (requires { answer.t; }) candidate.t = answer.t;
  if constexpr (requires { query.position_filter; })
    if (query.position_filter && !query.position_filter(candidate)) return std::nullopt;
  const bool is_admitted = filters == Filters::of_position || !query.filter || query.filter(candidate);
  return is_admitted ? std::optional(answer) : std::nullopt;
}

/// Radius of a point with this spacing: see RayQuery::spacing_factor.
inline double own_radius(const RayQuery& query, double spacing) {
  return std::min(query.radius, query.spacing_factor * spacing);
}

/// radius: of this point.
inline std::optional<Hit> evaluate(const Ray& ray, const RayQuery& query, double radius,
                                   const glm::dvec3& position, std::uint64_t point_id,
                                   std::size_t query_index, Filters filters = Filters::all) {
  const RayProjection projection = project(ray, position);
  if (!(projection.distance <= radius && projection.t >= ray.t_min && projection.t <= ray.t_max)) {
    return std::nullopt;
  }
  const double entered_at = entry(projection, radius);
  if (!(entered_at >= query.entry_min)) return std::nullopt;
  const Hit hit{point_id, position, projection.t, projection.distance, entered_at};
  return admitted(query, hit, query_index, radius, nullptr, filters);
}

/// Radius of the sphere of a point without a sheet, whose own radius is this: see DiscQuery.
inline double lone_radius(const RayQuery& query, double radius) {
  return std::min({radius, query.discs.lone_factor / query.spacing_factor * radius, query.discs.lone_radius});
}

/// Measure::crossing. radius, surface, packed_edge: of this point.
inline std::optional<Hit> evaluate_crossing(const Ray& ray, const RayQuery& query, double radius,
                                            const PointSurface& surface, std::uint8_t packed_edge,
                                            const glm::dvec3& position, std::uint64_t point_id,
                                            std::size_t query_index, Filters filters = Filters::all) {
  const RayProjection projection = project(ray, position);
  const double sphere = surface.exists ? radius : lone_radius(query, radius);
  if (!(projection.distance <= sphere)) return std::nullopt;
  const double entered_at = entry(projection, sphere);
  double t = entered_at;
  PointDisc disc;
  if (surface.exists) {
    disc = point_disc(position, surface, radius);
    const std::optional<double> crossed = plane_crossing(disc, ray.origin, ray.direction);
    if (!crossed) return std::nullopt;
    const double beside = *crossed - projection.t;
    if (!(beside * beside <= radius * radius - projection.distance * projection.distance))
      return std::nullopt;
    // Within the sphere, also where that is rounding, so that bounds of entries are bounds of crossings.
    t = std::max(*crossed, entered_at);
  }
  if (!(t >= ray.t_min && t <= ray.t_max && entered_at >= query.entry_min)) return std::nullopt;
  // Spacings do not follow from the widest radius.
  if (surface.exists && radius < query.radius &&
      is_beyond_edge(disc, ray.origin + t * ray.direction, packed_edge, query.spacing_factor,
                     query.discs.edge_shift))
    return std::nullopt;
  if (surface.exists && !query.discs.begins.empty() &&
      is_left(query.discs.begins[query_index], disc, ray.origin))
    return std::nullopt;
  return admitted(query, Hit{point_id, position, t, projection.distance, entered_at}, query_index, radius,
                  surface.exists ? &disc : nullptr, filters);
}

/// The point at a storage index as an answer to a ray, if the points have radii of their own.
inline std::optional<Hit> evaluate_own(const Ray& ray, const RayQuery& query, const TreeView& tree,
                                       std::uint32_t index, const glm::dvec3& position,
                                       std::size_t query_index, Filters filters = Filters::all) {
  const double radius = own_radius(query, spacing_at(tree, index));
  const std::uint64_t id = point_id(tree, index);
  if (query.measure == Measure::crossing)
    return evaluate_crossing(ray, query, radius, surface_at(tree, index), tree.stored_edges[index], position,
                             id, query_index, filters);
  return evaluate(ray, query, radius, position, id, query_index, filters);
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
  switch (measure) {
    case Measure::distance:
      return hit.distance;
    case Measure::t:
    case Measure::crossing:
      return hit.t;
    default:
      return hit.entry;
  }
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
