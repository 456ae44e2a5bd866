// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>

#include "octree/candidate.h"
#include "visibility/sight_line.h"

// How one point blocks one line: the filter of the ray queries that sight lines are, and of brute force.

namespace alidade::visibility {

// Radii in spacings, where each point has its own. Discs of 0.92 spacings leave 0.1 % of a surface of random
// points uncovered, exp(-8 * 0.92^2), and reach little beyond its edges.
constexpr double k_disc_share = 0.92, k_sphere_share = 0.5;
// Points without a surface among discs, mostly at edges, are spheres that need to close little.
constexpr double k_lone_share = 0.35;

/// Position where a line meets the plane of a point's disc, whatever the disc's width and the line's ends;
/// metres from its start. Empty for a line in the plane.
inline std::optional<double> meeting_position(const SightLine& line, const glm::dvec3& center,
                                              const glm::dvec3& normal) {
  const double slope = glm::dot(line.direction, normal);
  const double position = glm::dot(center - line.from.position, normal) / slope;
  if (slope == 0.0 || !std::isfinite(position)) return std::nullopt;
  return position;
}

/// Whether a disc is part of the surface that an end lies on.
inline bool is_own(const SightEnd& end, const glm::dvec3& point, double radius, const glm::dvec3& center,
                   const glm::dvec3& normal) {
  constexpr double k_radii = 3.0;
  const glm::dvec3 offset = end.position - point;
  const double reach = std::max(end.own_reach, k_radii * radius);
  return end.own_reach > 0.0 && glm::dot(offset, offset) <= reach * reach &&
         std::fabs(glm::dot(end.position - center, normal)) <= end.own_thickness;
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
                  (occluders.has_surfaces() ? k_disc_share : k_sphere_share) * spacing);
}

/// Radius of the sphere of a point without a surface; radius: candidate_radius().
inline double sphere_of(const Occluders& occluders, double radius) {
  if (occluders.options().radius || !occluders.has_surfaces()) return radius;
  return std::min(k_lone_share / k_disc_share * radius, occluders.largest_sphere());
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
    if (!endless && is_within(line.to, candidate.position, radius)) return std::nullopt;
    return candidate.t;
  }
  const glm::dvec3 center = candidate.position - surface.height * surface.normal;
  const std::optional<double> position = meeting_position(line, center, surface.normal);
  if (!position || !(*position >= 0.0 && *position <= line.length)) return std::nullopt;
  const glm::dvec3 offset = line.from.position + *position * line.direction - candidate.position;
  if (!(glm::dot(offset, offset) <= candidate.radius * candidate.radius)) return std::nullopt;
  // Radii that are given are those of whole discs, and of widest ones spacings do not follow from the radius.
  if (!occluders.options().radius && candidate.radius < occluders.largest_radius()) {
    const SheetEdge edge = edge_of(occluders.octree().view(), candidate.point_id, surface.normal);
    if (glm::dot(offset, edge.direction) * k_disc_share > edge.distance * candidate.radius)
      return std::nullopt;
  }
  if (is_own(line.from, candidate.position, candidate.radius, center, surface.normal)) return std::nullopt;
  if (!endless && is_own(line.to, candidate.position, candidate.radius, center, surface.normal))
    return std::nullopt;
  return position;
}

}  // namespace alidade::visibility
