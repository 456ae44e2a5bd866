// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>

#include "octree/octree.h"

// The distance between two surfaces of points along a normal, and how large it must be not to be an effect of
// noise: M3C2 (Lague, Brodu, Leroux 2013, Accurate 3D comparison of complex topography with terrestrial laser
// scanner, ISPRS Journal 82). Each surface is the mean of its points in a cylinder around the normal. Unlike
// there, a cylinder that holds several surfaces gives the mean of one of them.

namespace alidade::visibility {

/// A cylinder around the normal of a point.
struct Cylinder {
  glm::dvec3 center{0.0};          ///< the point; t = 0 on the axis
  glm::dvec3 axis{0.0, 0.0, 1.0};  ///< the normal, of length 1
  double radius = 0.0;             ///< metres, > 0
  double half_length = 0.0;        ///< to either side of the point, metres
  /// Points of one surface lie within this of its mean, metres along the axis, > 0.
  double window = 0.0;
};

/// A surface in a cylinder.
struct CylinderSurface {
  std::size_t count = 0;   ///< points of the surface, at least 1
  double t = 0.0;          ///< their mean along the axis, metres
  double deviation = 0.0;  ///< their standard deviation along the axis, metres; 0 for a single point
  glm::dvec3 middle{0.0};  ///< their mean, world coordinates
};

/// Points that count; empty: all.
using CountedPoints = std::function<bool(std::uint64_t point_id)>;

/// The surface nearest to t on the axis: the mean of the points within the window around the point nearest to
/// t, then of those around this mean, until it no longer changes (at most 8 times). Empty: the cylinder holds
/// no point. The same bits on any machine. Cost: some microseconds, grows with the points in the cylinder.
std::optional<CylinderSurface> nearest_surface(const Octree& octree, const Cylinder& cylinder, double t,
                                               const CountedPoints& counts = {});

/// Levels of detection of fewer points are not reliable.
constexpr std::size_t k_least_cylinder_points = 4;

/// The level of detection with a confidence of 95 % (LoD95): 1.96 (sqrt(s1^2 / n1 + s2^2 / n2) + registration
/// error), metres. A distance that exceeds it is significant. registration_error: standard deviation of the
/// offset between both clouds, metres.
double detection_level(const CylinderSurface& one, const CylinderSurface& other, double registration_error);

}  // namespace alidade::visibility
