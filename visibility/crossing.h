// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>

#include "octree/candidate.h"
#include "octree/point_disc.h"
#include "visibility/sight_line.h"

// How one point blocks one line: the filter of the ray queries that sight lines are, and of brute force.

namespace alidade::visibility {

// Radii in spacings, where each point has its own: where all are spheres, and of points without a surface among discs.
// These, mostly at edges and in foliage, need to close little; from 0.25 down lines pass between the foot of a wall and
// the ground.
constexpr double k_sphere_share = 0.5, k_lone_share = 0.28;
// Widest disc, in automatic radii, and from which radius on spheres among discs shrink again: a bird or a stray return
// is no larger for having its neighbours far away.
constexpr double k_widest_disc = 16.0, k_widest_lone = 0.35;

/// Whether a disc is part of the surface that an end lies on. A disc is no better known than its sheet is thick.
inline bool is_own(const SightEnd& end, const PointDisc& disc, const PointSurface& surface) {
  return end.own_reach > 0.0 && is_part_of_surface(disc, end.position, end.own_reach,
                                                   std::max(end.own_thickness, surface.thickness));
}

/// Whether what a line meets this far from an end, of a point with this radius, is of the same thing as the end.
inline bool is_beside(const SightEnd& end, double distance, double radius) {
  return end.is_lone && distance < k_lone_radii * radius;
}

/// Whether an end lies in a sphere.
inline bool is_within(const SightEnd& end, const glm::dvec3& point, double radius) {
  const glm::dvec3 offset = end.position - point;
  return glm::dot(offset, offset) <= radius * radius;
}

/// Radius that the queries of sight lines give a point with this spacing: Candidate::radius.
inline double candidate_radius(const Occluders& occluders, double spacing) {
  if (occluders.options().radius) return *occluders.options().radius;
  return std::min(occluders.largest_radius(),
                  (occluders.has_surfaces() ? k_disc_spacings : k_sphere_share) * spacing);
}

/// Radius of the disc of a point; radius: candidate_radius(), which a largest one does not limit, since edges and
/// spheres follow from the spacing in it.
inline double disc_of(const Occluders& occluders, double radius) {
  return std::min(radius, occluders.options().radius_max.value_or(radius));
}

/// Radius of the sphere of a point without a surface; radius: candidate_radius().
inline double sphere_of(const Occluders& occluders, double radius) {
  if (occluders.options().radius || !occluders.has_surfaces()) return disc_of(occluders, radius);
  const double own = k_lone_share / k_disc_spacings * radius,
               widest = k_widest_lone * occluders.typical_radius();
  return disc_of(occluders, own < widest ? own : widest * widest / own);
}

/// Where a point blocks a line, metres from the line's start; empty if it does not.
inline std::optional<double> crossing(const Occluders& occluders, const SightLine& line,
                                      const Candidate& candidate) {
  if (const auto& counts = occluders.options().counts; counts && !counts(candidate.point_id))
    return std::nullopt;
  const PointSurface surface = occluders.surface(candidate.point_id);
  const bool endless = line.length == std::numeric_limits<double>::infinity();
  if (!surface.exists) {
    if (occluders.options().shape == OccluderShape::disc) return std::nullopt;
    const double radius = sphere_of(occluders, candidate.radius);
    if (!(candidate.distance <= radius && candidate.t >= 0.0 && candidate.t <= line.length))
      return std::nullopt;
    if (is_within(line.from, candidate.position, radius)) return std::nullopt;
    if (!endless && (is_within(line.to, candidate.position, radius) ||
                     is_beside(line.to, line.length - candidate.t, candidate.radius)))
      return std::nullopt;
    return candidate.t;
  }
  const PointDisc disc = point_disc(candidate.position, surface, candidate.radius);
  const std::optional<double> position = plane_crossing(disc, line.from.position, line.direction);
  if (!position || !(*position >= 0.0 && *position <= line.length)) return std::nullopt;
  const glm::dvec3 met = line.from.position + *position * line.direction;
  const double radius = disc_of(occluders, candidate.radius);
  if (!is_within_radius({disc.point, disc.center, disc.normal, radius}, met)) return std::nullopt;
  // Radii that are given are those of whole discs, and of widest ones spacings do not follow from the radius.
  const bool has_edge = !occluders.options().radius && candidate.radius < occluders.largest_radius();
  if (has_edge &&
      is_beyond_edge(disc, met, occluders.octree().view().sheet_edges[candidate.point_id], k_disc_spacings))
    return std::nullopt;
  if (is_own(line.from, disc, surface)) return std::nullopt;
  if (!endless &&
      (is_own(line.to, disc, surface) || is_beside(line.to, line.length - *position, candidate.radius)))
    return std::nullopt;
  return position;
}

}  // namespace alidade::visibility
