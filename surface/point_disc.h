// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "surface/point_surface.h"
#include "surface/surface_cloud.h"

// The disc that rays and lines of sight meet in place of a point of a sheet. It lies on the plane of the
// sheet, within the radius of the point, and is cut off where the sheet ends.

namespace alidade {

struct PointDisc {
  glm::dvec3 point{0.0};   ///< the point itself
  glm::dvec3 center{0.0};  ///< below or above it on the sheet
  glm::dvec3 normal{0.0, 0.0, 1.0};
  double radius = 0.0;
};

/// surface: that of the point, which exists.
inline PointDisc point_disc(const glm::dvec3& point, const PointSurface& surface, double radius) {
  return {point, point - surface.height * surface.normal, surface.normal, radius};
}

/// Where a line meets the disc's plane, metres from its origin along its direction, whatever the disc's
/// width. Empty for a line in the plane.
inline std::optional<double> plane_crossing(const PointDisc& disc, const glm::dvec3& origin,
                                            const glm::dvec3& direction) {
  const double slope = glm::dot(direction, disc.normal);
  const double t = glm::dot(disc.center - origin, disc.normal) / slope;
  if (slope == 0.0 || !std::isfinite(t)) return std::nullopt;
  return t;
}

/// Whether a position is within the radius of the point, whether or not the sheet ends before.
inline bool is_within_radius(const PointDisc& disc, const glm::dvec3& position) {
  const glm::dvec3 offset = position - disc.point;
  return glm::dot(offset, offset) <= disc.radius * disc.radius;
}

/// Whether a position on the plane lies beyond the edge of the sheet, as it is stored, shifted outwards by so
/// many spacings. Requires: the radius is `spacings` of the point's spacings.
inline bool is_beyond_edge(const PointDisc& disc, const glm::dvec3& position, std::uint8_t packed_edge,
                           double spacings, double shift = 0.0) {
  if (packed_edge == 0) return false;
  const SheetEdge edge = unpack_edge(packed_edge, disc.normal);
  return glm::dot(position - disc.point, edge.direction) * spacings > (edge.distance + shift) * disc.radius;
}

/// Radii of a disc within which it may be part of the surface that a position lies on.
constexpr double k_part_radii = 3.0;

/// Whether a disc is part of the surface that a position lies on: the disc's point is near, within `reach` or
/// 3 of its radii, and its plane passes within `thickness` of the position. Metres.
inline bool is_part_of_surface(const PointDisc& disc, const glm::dvec3& position, double reach,
                               double thickness) {
  const glm::dvec3 offset = position - disc.point;
  const double limit = std::fmax(reach, k_part_radii * disc.radius);
  return glm::dot(offset, offset) <= limit * limit &&
         std::fabs(glm::dot(position - disc.center, disc.normal)) <= thickness;
}

/// Cosine of the 32 degrees by which normals of one sheet deviate at most.
constexpr double k_same_sheet_cosine = 0.848;

/// Whether a disc is of the sheet that a ray from `origin` begins on.
inline bool is_left(const SheetOrigin& begin, const PointDisc& disc, const glm::dvec3& origin) {
  return begin.reach > 0.0f && std::fabs(glm::dot(disc.normal, begin.normal)) >= k_same_sheet_cosine &&
         is_part_of_surface(disc, origin, begin.reach, begin.thickness);
}

}  // namespace alidade
