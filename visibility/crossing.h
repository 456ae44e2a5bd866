// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>

#include "base/ray.h"
#include "octree/packed_surface.h"
#include "octree/point_disc.h"
#include "octree/query.h"
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

/// How far from a disc's plane its sheet still lies, in thicknesses of the sheet, which are standard deviations.
constexpr double k_sheet_reach = 1.5;

/// How far the plane of a disc may be stored from its sheet at a position of that sheet, metres. Its normal is turned by
/// rounding. And moments are sums of floats in units of the reach of a fit, 2.5 spacings, so the variance of heights errs
/// by some 2^-25: 1.7e-4 of the reach or 4.3e-4 of a spacing are a thickness of 0. Three of those are 1.4e-3 of a radius.
/// Next to these, noise is nothing on planes of meshes, plans and elevation models.
inline double error_of_plane(const PointDisc& disc, const glm::dvec3& position) {
  constexpr double k_unseen_thickness = 1.4e-3;
  return packed_surface::k_normal_error * glm::length(position - disc.point) +
         k_unseen_thickness * disc.radius;
}

/// Whether a disc is part of the surface that an end lies on. A disc is no better known than its sheet is thick, and than
/// its plane is stored.
inline bool is_own(const SightEnd& end, const PointDisc& disc, const PointSurface& surface) {
  return end.own_reach > 0.0 &&
         is_part_of_surface(disc, end.position, end.own_reach,
                            std::max({end.own_thickness, k_sheet_reach * surface.thickness,
                                      error_of_plane(disc, end.position)}));
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

/// Whether points are discs of their own radii among spheres: the octree finds their crossings (Measure::crossing).
/// Otherwise it finds points near the line (Measure::t), and crossing() tests their discs.
inline bool has_own_discs(const Occluders& occluders) {
  return occluders.has_surfaces() && !occluders.options().radius;
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

/// No sphere among discs of own radii is wider.
inline double widest_sphere(const Occluders& occluders) {
  return k_widest_lone * occluders.typical_radius();
}

/// Radius of the sphere of a point without a surface; radius: candidate_radius().
inline double sphere_of(const Occluders& occluders, double radius) {
  if (!has_own_discs(occluders)) return disc_of(occluders, radius);
  const double own = k_lone_share / k_disc_spacings * radius, widest = widest_sphere(occluders);
  return disc_of(occluders, own < widest ? own : widest * widest / own);
}

/// Radius of what a candidate blocks lines with.
inline double width_of(const Occluders& occluders, const Candidate& candidate) {
  const bool is_disc = occluders.surface(candidate.point_id).exists;
  return is_disc ? disc_of(occluders, candidate.radius) : sphere_of(occluders, candidate.radius);
}

/// What finds the candidates on the rays of lines, still without a filter.
inline RayQuery query_of(const Occluders& occluders) {
  RayQuery query{.radius = occluders.largest_radius(), .measure = Measure::t};
  if (occluders.options().radius) return query;
  query.spacing_factor = k_sphere_share;
  if (!has_own_discs(occluders)) return query;
  query.measure = Measure::crossing;
  query.spacing_factor = k_disc_spacings;
  query.lone_factor = k_lone_share;
  query.lone_radius = widest_sphere(occluders);
  return query;
}

/// The ray whose candidates hold every point that can block.
inline Ray ray_of(const Occluders& occluders, const SightLine& line) {
  // Lines meet spheres before their middle.
  if (has_own_discs(occluders))
    return {line.from.position, line.direction, -widest_sphere(occluders), line.length};
  const double radius = occluders.largest_radius();
  return {line.from.position, line.direction, -radius, line.length + radius};
}

/// The largest distance by which a candidate blocks before its t, metres. A sphere blocks at its middle, behind its t.
inline double reach_before(const Occluders& occluders) {
  return has_own_discs(occluders) ? 0.0 : occluders.largest_radius();
}

/// Where the sphere of a point without a surface blocks a line, as crossing().
inline std::optional<double> sphere_crossing(const Occluders& occluders, const SightLine& line,
                                             const Candidate& candidate) {
  if (occluders.options().shape == OccluderShape::disc) return std::nullopt;
  const double radius = sphere_of(occluders, candidate.radius);
  if (!(candidate.distance <= radius)) return std::nullopt;
  const double middle = glm::dot(candidate.position - line.from.position, line.direction);
  if (!(middle >= 0.0 && middle <= line.length) || is_within(line.from, candidate.position, radius))
    return std::nullopt;
  if (line.has_end() && (is_within(line.to, candidate.position, radius) ||
                         is_beside(line.to, line.length - middle, candidate.radius)))
    return std::nullopt;
  return middle;
}

/// Where a line crosses a disc that the query did not test.
inline std::optional<double> disc_crossing(const SightLine& line, const PointDisc& disc) {
  const std::optional<double> position = plane_crossing(disc, line.from.position, line.direction);
  if (!position || !(*position <= line.length) ||
      !is_within_radius(disc, line.from.position + *position * line.direction))
    return std::nullopt;
  return position;
}

/// Where a point blocks a line if it counts (OccluderOptions::counts), metres from the line's start; empty if it does
/// not. The same for all points of one position. Requires a candidate of query_of() and ray_of().
inline std::optional<double> position_crossing(const Occluders& occluders, const SightLine& line,
                                               const Candidate& candidate) {
  const OccluderOptions& options = occluders.options();
  if (has_own_discs(occluders) && candidate.disc == nullptr)
    return sphere_crossing(occluders, line, candidate);
  const PointSurface surface = occluders.surface(candidate.point_id);
  if (!surface.exists) return sphere_crossing(occluders, line, candidate);
  const PointDisc disc =
      candidate.disc != nullptr ? *candidate.disc : point_disc(candidate.position, surface, candidate.radius);
  const std::optional<double> position = candidate.disc != nullptr ? candidate.t : disc_crossing(line, disc);
  if (!position || !(*position >= 0.0)) return std::nullopt;
  if (options.radius_max) {
    PointDisc cut = disc;
    cut.radius = disc_of(occluders, disc.radius);
    if (!is_within_radius(cut, line.from.position + *position * line.direction)) return std::nullopt;
  }
  if (is_own(line.from, disc, surface)) return std::nullopt;
  if (line.has_end() &&
      (is_own(line.to, disc, surface) || is_beside(line.to, line.length - *position, candidate.radius)))
    return std::nullopt;
  return position;
}

inline bool is_counted(const Occluders& occluders, std::uint64_t point_id) {
  return !occluders.options().counts || occluders.options().counts(point_id);
}

/// Where a point blocks a line, as position_crossing(); empty if it does not count.
inline std::optional<double> crossing(const Occluders& occluders, const SightLine& line,
                                      const Candidate& candidate) {
  return is_counted(occluders, candidate.point_id) ? position_crossing(occluders, line, candidate)
                                                   : std::nullopt;
}

}  // namespace alidade::visibility
