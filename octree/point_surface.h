// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "base/progress.h"
#include "octree/octree.h"

namespace alidade {

/// A direction whose side is free, as two whole numbers in [0, steps], which must be even so that upright
/// stays upright. Source: the octahedral map of Cigolle et al., A Survey of Efficient Representations for
/// Independent Unit Vectors, JCGT 2014; the upper half alone, whose square turned by 45 degrees fills the
/// whole range.
inline glm::uvec2 pack_normal(const glm::dvec3& normal, double steps) {
  const glm::dvec3 n = normal / (std::fabs(normal.x) + std::fabs(normal.y) + std::fabs(normal.z));
  const double sign = n.z < 0.0 ? -1.0 : 1.0;
  const auto step = [&](double position) {
    return static_cast<std::uint32_t>((0.5 + 0.5 * position) * steps + 0.5);
  };
  return {step(sign * (n.x + n.y)), step(sign * (n.x - n.y))};
}

/// Of length 1, z >= 0.
inline glm::dvec3 unpack_normal(const glm::uvec2& packed, double steps) {
  const double u = packed.x / steps * 2.0 - 1.0, v = packed.y / steps * 2.0 - 1.0;
  const double x = 0.5 * (u + v), y = 0.5 * (u - v);
  return glm::normalize(glm::dvec3(x, y, 1.0 - std::fabs(x) - std::fabs(y)));
}

// The surface that each point of a cloud was measured on: what makes discs of points.
//
//   const Octree octree = with_surfaces(with_spacings(build(cloud), 8));
//   const PointSurface surface = surface_of(octree.view(), hit.point_id);

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

/// The same octree with the surface of every point, as surface_of() returns it. An octree that has surfaces is
/// returned as it is. `progress` is in points. Requires spacings. Cost: 1 to 2 microseconds of one thread
/// per point, in parallel; 5 B per point. Where sheets end is measured, too (octree/point_surface.h). Points
/// that stand off the sheet of their neighbours by more than half their spacing have a surface only with
/// others like them. How: a plane is fitted (octree/local_plane.h) to the points within 2.5 spacings; where
/// these are no surface, within 1.5, 1.1 (another surface is near) and 5 (noise is as large as the spacing).
/// Two sheets are two values of the heights above that plane: their coefficient of bimodality is near 1
/// (SAS/STAT User's Guide, The CLUSTER Procedure).
Octree with_surfaces(const Octree& octree, const Progress& progress = {});

/// The surface of a point: normals are good to 0.1 degree, heights to 19 %, thicknesses are rounded up by at
/// most 41 %. All queries that take discs take these rounded values. Requires surfaces.
PointSurface surface_of(const TreeView& tree, std::uint64_t point_id);

// Where the sheet of points that a point belongs to ends beside it: at the edge of a roof, or where the
// scanner's shadow begins. There a disc around the point would reach out into the air.

/// The nearest edge of the sheet of a point.
struct SheetEdge {
  glm::dvec3 direction{0.0};  ///< of length 1, in the plane of the sheet, towards the edge
  /// In spacings of the point; infinite if none is near.
  double distance = std::numeric_limits<double>::infinity();
};

/// The edge beside a point, whose direction is one of 32 and whose distance is good to a tenth of a spacing.
/// Requires surfaces; normal: that of surface_of().
SheetEdge edge_of(const TreeView& tree, std::uint64_t point_id, const glm::dvec3& normal);

}  // namespace alidade
