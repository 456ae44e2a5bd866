// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <optional>

#include "octree/candidate.h"
#include "octree/spacing.h"
#include "surface/point_disc.h"
#include "surface/surface_cloud.h"

// How one point of a SurfaceCloud is decided, as octree/candidate.h decides those of one radius.

namespace alidade {

/// Radius of the sphere of a point without a sheet, whose own radius is this: see DiscQuery. Requires discs.
inline double lone_radius(const SurfaceQuery& query, double radius) {
  return std::min(
      {radius, query.discs->lone_factor / query.spacing_factor * radius, query.discs->lone_radius});
}

/// What answers are ordered by.
inline Measure order_of(const SurfaceQuery& query) {
  return query.discs ? Measure::t : query.measure;
}

/// A point as a disc. radius, surface, packed_edge: of this point.
inline std::optional<Hit> evaluate_disc(const Ray& ray, const SurfaceQuery& query, double radius,
                                        const PointSurface& surface, std::uint8_t packed_edge,
                                        const glm::dvec3& position, std::uint64_t point_id,
                                        std::size_t query_index, Filters filters = Filters::all) {
  const DiscQuery& discs = *query.discs;
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
                     discs.edge_shift))
    return std::nullopt;
  if (surface.exists && !discs.begins.empty() && is_left(discs.begins[query_index], disc, ray.origin))
    return std::nullopt;
  return admitted(query, Hit{point_id, position, t, projection.distance, entered_at}, query_index, radius,
                  surface.exists ? &disc : nullptr, filters);
}

/// The point at a storage index as an answer to a ray.
inline std::optional<Hit> evaluate(const Ray& ray, const SurfaceQuery& query, const SurfaceView& view,
                                   std::uint32_t index, const glm::dvec3& position, std::size_t query_index,
                                   Filters filters = Filters::all) {
  const double radius = own_radius(query, spacing_at(view.layers, index));
  const std::uint64_t id = point_id(view.tree, index);
  if (!query.discs) return evaluate(ray, query, radius, position, id, query_index, filters);
  const PointSurface surface = unpack_surface(view.stored_surfaces[index], view.layers.surface_unit);
  return evaluate_disc(ray, query, radius, surface, view.stored_edges[index], position, id, query_index,
                       filters);
}

}  // namespace alidade
