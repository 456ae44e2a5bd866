// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>

#include "base/progress.h"
#include "octree/octree.h"

namespace alidade {

// The surface that each point of a cloud was measured on: what makes discs of points.
//
//   const Octree octree = with_surfaces(with_spacings(build(cloud), 8));
//   const PointSurface surface = surface_of(octree.layers(), hit.point_id);

/// The sheet of points that a point belongs to. Two sheets close together, such as both sides of a thin
/// plate, are distinguished where points keep nearer to their sheet than an eighth of what lies between them.
struct PointSurface {
  bool exists = false;               ///< otherwise there is none: foliage, wires, lone points
  glm::dvec3 normal{0.0, 0.0, 1.0};  ///< unit; which of the two sides is not defined
  double height = 0.0;               ///< of the point above its sheet, along the normal, metres
  double thickness = 0.0;            ///< standard deviation of the sheet's points from it, metres
};

/// Spacings to this neighbour are what surfaces are meant to be fitted with.
constexpr int k_surface_neighbours = 8;

/// Area that a point of a sheet represents, by its spacing: an eighth of the circle through its 8th
/// neighbour, which is right on average for points scattered at random.
inline double area_of_point(double spacing) {
  return std::numbers::pi / k_surface_neighbours * spacing * spacing;
}

/// This octree with the surface of every point, as surface_of() returns it. An octree that has surfaces is
/// returned as it is. `progress` is in points. Requires spacings. Cost: some 0.8 microseconds of one thread
/// per point, in parallel; 5 B per point. The edges of sheets are measured as well (edge_of()).
///
/// Points that are off the sheet of their neighbours by more than half their spacing have a surface only with
/// others like them, and points that lie much thinner than what is around them on more than one sheet have
/// none: the disc of a bird or a stray return would be wider than any sheet. Points whose spacing is more
/// than 4 times the automatic radius (octree/spacing.h) have one only where a sheet within 2.5 spacings is
/// thinner than 0.07 of a spacing.
///
/// How: a plane is fitted (surface/local_plane.h) to the points within 2.5 spacings; where these are no
/// surface, within 1.5, 1.1 (another surface is near) and 5 (noise is as large as the spacing). Two sheets
/// are two values of the heights above that plane: their coefficient of bimodality is near 1 (SAS/STAT User's
/// Guide, The CLUSTER Procedure).
Octree with_surfaces(const Octree& octree, const Progress& progress = {});

/// The surface of a point: normals are good to 0.14 degrees, heights to 19 %, thicknesses are rounded up by
/// at most 41 %. All queries that take discs take these rounded values. Requires surfaces.
PointSurface surface_of(const PointLayers& layers, std::uint64_t point_id);

/// A surface as it is stored (surface/packed_surface.h). unit: PointLayers::surface_unit, metres.
PointSurface unpack_surface(std::uint32_t packed, double unit);

// Where the sheet of points that a point belongs to ends beside it: at the edge of a roof, or where the
// scanner's shadow begins. There a disc around the point would reach out into the air.

/// The nearest edge of the sheet of a point.
struct SheetEdge {
  glm::dvec3 direction{0.0};  ///< of length 1, in the plane of the sheet, towards the edge
  /// In spacings of the point; infinite if none is near.
  double distance = std::numeric_limits<double>::infinity();
};

/// An edge as it is stored: one of 32 directions, and a distance that is good to a tenth of a spacing.
/// normal: that of the point's surface.
SheetEdge unpack_edge(std::uint8_t packed, const glm::dvec3& normal);

/// The edge beside a point. Requires surfaces.
inline SheetEdge edge_of(const PointLayers& layers, std::uint64_t point_id, const glm::dvec3& normal) {
  return unpack_edge(layers.sheet_edges[point_id], normal);
}

}  // namespace alidade
