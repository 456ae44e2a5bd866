// SPDX-License-Identifier: MIT
#include "visibility/lines/line_points.h"

#include "octree/distance.h"
#include "octree/path_index.h"
#include "octree/point_surface.h"
#include "octree/query.h"

namespace alidade {
namespace {

/// The middle line as what queries ask with.
struct Middle {
  const LineCurve& curve;
  std::vector<double> joints;
  Path path;

  explicit Middle(const LineCurve& line) : curve(line), joints(line.joints()) {
    std::vector<glm::dvec3> vertices;
    for (const double t : joints) vertices.push_back(curve.position(t));
    path = make_path(vertices);
  }

  /// Along the chord, for a place along the path.
  double chord_place(std::size_t segment, double path_t) const {
    const double begin = path.vertex_t[segment], length = path.vertex_t[segment + 1] - begin;
    return joints[segment] + (path_t - begin) / length * (joints[segment + 1] - joints[segment]);
  }
};

bool may_block(const Occluders& occluders, std::uint64_t point_id) {
  const OccluderOptions& options = occluders.options();
  if (options.counts && !options.counts(point_id)) return false;
  return options.shape != OccluderShape::disc || surface_of(occluders.octree().view(), point_id).exists;
}

/// What lies nearest to an end of the path lies beside no place between its ends.
CandidateFilter beside(const Occluders& occluders, const Middle& middle) {
  return [&occluders, &middle](const Candidate& point) {
    if (!(point.t > 0.0 && point.t < middle.path.vertex_t.back())) return false;
    for (const SightEnd* const end : {&middle.curve.from(), &middle.curve.to()}) {
      if (distance(end->position, point.position) <= end->own_reach) return false;
    }
    return may_block(occluders, point.point_id);
  };
}

/// Straight lines are asked for as rays, which is ten times as fast.
std::optional<Ray> ray_of(const Middle& middle) {
  return middle.joints.size() == 2 ? std::optional(segment_of(middle.path, 0).line) : std::nullopt;
}

LinePoint line_point(const Middle& middle, const Hit& hit) {
  return {hit.point_id, hit.position, middle.chord_place(0, hit.t), hit.distance};
}

LinePoint line_point(const Middle& middle, const PathHit& hit) {
  return {hit.point_id, hit.position, middle.chord_place(hit.segment, hit.t), hit.distance};
}

/// Those of the hits that lie in the zone.
template <class Hits>
std::vector<LinePoint> within_zone(const Middle& middle, const Hits& hits) {
  std::vector<LinePoint> points;
  for (const auto& hit : hits) {
    const LinePoint point = line_point(middle, hit);
    if (point.distance <= middle.curve.zone_radius(point.t)) points.push_back(point);
  }
  return points;
}

}  // namespace

std::optional<LinePoint> nearest_point(const Occluders& occluders, const LineCurve& curve) {
  if (!(curve.begin() < curve.end())) return std::nullopt;
  const Middle middle(curve);
  const CandidateFilter filter = beside(occluders, middle);
  if (const std::optional<Ray> ray = ray_of(middle)) {
    const std::optional<Hit> hit =
        closest(occluders.octree(), *ray, {.measure = Measure::distance, .filter = filter});
    return hit ? std::optional(line_point(middle, *hit)) : std::nullopt;
  }
  const std::vector<PathHit> hits =
      find(occluders.octree(), middle.path, {.measure = Measure::distance, .k = 1, .filter = filter});
  return hits.empty() ? std::nullopt : std::optional(line_point(middle, hits.front()));
}

std::vector<LinePoint> points_in_zone(const Occluders& occluders, const LineCurve& curve) {
  if (!(curve.begin() < curve.end())) return {};
  const Middle middle(curve);
  const CandidateFilter filter = beside(occluders, middle);
  // Wide enough for the whole zone; which of these points lie in it is decided one by one.
  const double radius = curve.zone_radius(0.5 * curve.length());
  if (const std::optional<Ray> ray = ray_of(middle)) {
    return within_zone(
        middle, find(occluders.octree(), *ray, {.radius = radius, .measure = Measure::t, .filter = filter}));
  }
  return within_zone(middle, find(occluders.octree(), middle.path, {.radius = radius, .filter = filter}));
}

}  // namespace alidade
