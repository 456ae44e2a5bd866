// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>
#include <span>

#include "base/ray.h"
#include "octree/query.h"
#include "surface/packed_surface.h"
#include "surface/point_disc.h"
#include "visibility/sight_line.h"

// How one point blocks one line: the filter of the ray queries that answer sight lines, and of brute force.

namespace alidade::visibility {

// Radii in spacings, if each point has its own: of spheres where all points are spheres, and of spheres among
// discs. The latter, mostly at edges and in foliage, have few gaps to close; with 0.25 and less, lines pass
// between the foot of a wall and the ground.
constexpr double k_sphere_share = 0.5, k_lone_share = 0.28;
// The widest disc and the widest sphere among discs, in automatic radii. Spheres of points with wider
// spacings shrink again: a bird or a stray return is not larger because its neighbours are far away.
constexpr double k_widest_disc = 16.0, k_widest_lone = 0.35;

/// How far from a disc's plane its sheet still lies, in thicknesses of the sheet,
/// which are standard deviations.
constexpr double k_sheet_reach = 1.5;

/// Error of the stored plane of a disc at a position of its sheet, metres. Rounding turns the normal. And
/// moments are sums of floats in units of the reach of a fit, 2.5 spacings, so the variance of heights
/// errs by some 2^-25: a thickness of 1.7e-4 of the reach, or 4.3e-4 of a spacing, is indistinguishable
/// from 0. Three times that is 1.4e-3 of a radius. On planes of meshes, plans and elevation models these
/// errors are larger than the noise.
inline double error_of_plane(const PointDisc& disc, const glm::dvec3& position) {
  constexpr double k_unseen_thickness = 1.4e-3;
  return packed_surface::k_normal_error * glm::length(position - disc.point) +
         k_unseen_thickness * disc.radius;
}

/// Whether a disc is part of the surface that an end lies on. The plane of a disc is uncertain by the
/// thickness of its sheet and by the error of its stored plane.
inline bool is_own(const SightEnd& end, const PointDisc& disc, const PointSurface& surface) {
  return end.own_reach > 0.0 &&
         is_part_of_surface(disc, end.position, end.own_reach,
                            std::max({end.own_thickness, k_sheet_reach * surface.thickness,
                                      error_of_plane(disc, end.position)}));
}

/// Whether a disc or sphere of this radius that a line meets this far from an end is of
/// the same thing as the end.
inline bool is_beside(const SightEnd& end, double distance, double radius) {
  return end.is_lone && distance < k_lone_radii * radius;
}

/// Whether an end lies in a sphere.
inline bool is_within(const SightEnd& end, const glm::dvec3& point, double radius) {
  const glm::dvec3 offset = end.position - point;
  return glm::dot(offset, offset) <= radius * radius;
}

/// Whether points are discs with radii of their own, among spheres. If so, the query finds the crossings.
/// Otherwise it finds points near the line (Measure::t), and crossing() tests their discs.
inline bool has_own_discs(const Occluders& occluders) {
  return occluders.has_surfaces() && !occluders.options().radius;
}

/// Radius that a point with this spacing has in the queries of sight lines: Candidate::radius.
inline double candidate_radius(const Occluders& occluders, double spacing) {
  if (occluders.options().radius) return *occluders.options().radius;
  return std::min(occluders.largest_radius(),
                  (occluders.has_surfaces() ? k_disc_spacings : k_sphere_share) * spacing);
}

/// Radius of the disc of a point. radius: candidate_radius(), which OccluderOptions::radius_max does not
/// limit, since edges and spheres follow from the spacing in it.
inline double disc_of(const Occluders& occluders, double radius) {
  return std::min(radius, occluders.options().radius_max.value_or(radius));
}

/// Largest radius of the spheres among discs with radii of their own.
inline double widest_sphere(const Occluders& occluders) {
  return k_widest_lone * occluders.typical_radius();
}

/// Radius of the sphere of a point without a surface; radius: candidate_radius().
inline double sphere_of(const Occluders& occluders, double radius) {
  if (!has_own_discs(occluders)) return disc_of(occluders, radius);
  const double own = k_lone_share / k_disc_spacings * radius, widest = widest_sphere(occluders);
  return disc_of(occluders, own < widest ? own : widest * widest / own);
}

/// Radius of the disc or sphere with which a candidate blocks lines.
inline double width_of(const Occluders& occluders, const Candidate& candidate) {
  const bool is_disc = occluders.surface(candidate.point_id).exists;
  return is_disc ? disc_of(occluders, candidate.radius) : sphere_of(occluders, candidate.radius);
}

/// Calls use(cloud, query) with the query, without a filter, for the candidates along ray_of().
template <class Use>
auto with_query(const Occluders& occluders, const Use& use) {
  const double radius = occluders.largest_radius();
  if (occluders.options().radius)
    return use(occluders.octree(), RayQuery{.radius = radius, .measure = Measure::t});
  SurfaceQuery query{.radius = radius, .spacing_factor = k_sphere_share, .measure = Measure::t};
  if (has_own_discs(occluders)) {
    query.spacing_factor = k_disc_spacings;
    query.discs = DiscQuery{.lone_factor = k_lone_share, .lone_radius = widest_sphere(occluders)};
  }
  return use(occluders.surfaces(), query);
}

/// The ray whose candidates hold every point that can block.
inline Ray ray_of(const Occluders& occluders, const SightLine& line) {
  // A line enters a sphere before it passes the middle.
  if (has_own_discs(occluders))
    return {line.from.position, line.direction, -widest_sphere(occluders), line.length};
  const double radius = occluders.largest_radius();
  return {line.from.position, line.direction, -radius, line.length + radius};
}

/// How far before its t a candidate may block, metres. A sphere blocks at its middle, behind its t.
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
  const std::optional<double> t = plane_crossing(disc, line.from.position, line.direction);
  if (!t || !(*t <= line.length) || !is_within_radius(disc, line.from.position + *t * line.direction))
    return std::nullopt;
  return t;
}

/// Where a point blocks a line, metres from the line's start, whether or not OccluderOptions::counts
/// admits it; empty if it does not block. All points of one position have the same answer. Requires a
/// candidate of with_query() and ray_of().
inline std::optional<double> position_crossing(const Occluders& occluders, const SightLine& line,
                                               const Candidate& candidate) {
  const OccluderOptions& options = occluders.options();
  if (has_own_discs(occluders) && candidate.disc == nullptr)
    return sphere_crossing(occluders, line, candidate);
  const PointSurface surface = occluders.surface(candidate.point_id);
  if (!surface.exists) return sphere_crossing(occluders, line, candidate);
  const PointDisc disc =
      candidate.disc != nullptr ? *candidate.disc : point_disc(candidate.position, surface, candidate.radius);
  const std::optional<double> t = candidate.disc != nullptr ? candidate.t : disc_crossing(line, disc);
  if (!t || !(*t >= 0.0)) return std::nullopt;
  if (options.radius_max) {
    PointDisc cut = disc;
    cut.radius = disc_of(occluders, disc.radius);
    if (!is_within_radius(cut, line.from.position + *t * line.direction)) return std::nullopt;
  }
  if (is_own(line.from, disc, surface)) return std::nullopt;
  if (line.has_end() &&
      (is_own(line.to, disc, surface) || is_beside(line.to, line.length - *t, candidate.radius)))
    return std::nullopt;
  return t;
}

inline bool is_counted(const Occluders& occluders, std::uint64_t point_id) {
  return !occluders.options().counts || occluders.options().counts(point_id);
}

/// The filter that admits these; empty if all are.
inline CandidateFilter::Function counted_alone(const Occluders& occluders) {
  if (!occluders.options().counts) return {};
  return [&occluders](const Candidate& point) { return is_counted(occluders, point.point_id); };
}

/// As position_crossing(); empty for points that OccluderOptions::counts does not admit.
inline std::optional<double> crossing(const Occluders& occluders, const SightLine& line,
                                      const Candidate& candidate) {
  return is_counted(occluders, candidate.point_id) ? position_crossing(occluders, line, candidate)
                                                   : std::nullopt;
}

// Sight through things that are not solid: OccluderOptions::transparency above 1.

/// The k-th separate crossing of each line with points, k being the transparency; empty: seen.
/// Requires: as many blockers as lines. Cost: two to three times that of the first crossings.
void find_separate_blockers(const Occluders& occluders, const ChordLines& lines,
                            std::span<std::optional<Blocker>> blockers);

}  // namespace alidade::visibility
