// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "base/interval.h"
#include "base/ray.h"
#include "octree/targets.h"

// The formulas of the paper (Teuscher et al. 2026, section 3.2), for a point and for all points of a box.
// They are in no other code: brute force, the index and every outer layer decide with these
// functions, so their answers are the same bits. Floating-point contraction must be off wherever this header
// is compiled, otherwise a fused multiply-add rounds differently from machine to machine.
//
// A function of a box gives bounds on what the function of the same name gives for any point inside, see
// base/interval.h: it repeats the same operations in the same order. Change one, change both.

namespace alidade {

/// Where a point lies relative to a ray. All lengths in metres (the unit of the CRS).
struct RayProjection {
  double t = 0.0;         ///< of the orthogonal projection on the ray (eq. 2)
  double distance = 0.0;  ///< orthogonal distance to the ray's line (eq. 1)
};

/// Where the points of a box lie relative to a ray.
struct RayReach {
  Interval t;         ///< eq. 4, with sign (from eq. 2)
  Interval distance;  ///< high may be NaN or infinite where squares overflow
};

/// Projects a world point on a ray whose direction has length 1.
inline RayProjection project(const Ray& ray, const glm::dvec3& point) {
  const double x = point.x - ray.origin.x, y = point.y - ray.origin.y, z = point.z - ray.origin.z;
  const glm::dvec3& d = ray.direction;
  const double cross_x = y * d.z - z * d.y;
  const double cross_y = z * d.x - x * d.z;
  const double cross_z = x * d.y - y * d.x;
  return {x * d.x + y * d.y + z * d.z, std::sqrt(cross_x * cross_x + cross_y * cross_y + cross_z * cross_z)};
}

/// Euclidean norm of the least and the greatest magnitudes of three intervals.
inline Interval norm(const Interval& x, const Interval& y, const Interval& z) {
  const auto root = [](double a, double b, double c) { return std::sqrt(a * a + b * b + c * c); };
  return {root(least_magnitude(x), least_magnitude(y), least_magnitude(z)),
          root(greatest_magnitude(x), greatest_magnitude(y), greatest_magnitude(z))};
}

inline RayReach project(const Ray& ray, const Bounds& box) {
  const auto [x, y, z] = relative(box, ray.origin);
  const glm::dvec3& d = ray.direction;
  return {x * d.x + y * d.y + z * d.z, norm(y * d.z - z * d.y, z * d.x - x * d.z, x * d.y - y * d.x)};
}

/// Where the ray enters the sphere of `radius` around the point: t - sqrt(radius^2 - distance^2); -infinity
/// if the radius is infinite. Requires distance <= radius. Never falls when t or distance grow, not even by
/// rounding, so lower bounds of these give a lower bound of it.
inline double entry(const RayProjection& projection, double radius) {
  if (std::isinf(radius)) return -radius;
  const double half_chord_sq = radius * radius - projection.distance * projection.distance;
  return projection.t - (half_chord_sq > 0.0 ? std::sqrt(half_chord_sq) : 0.0);
}

/// Distance of two points.
inline double distance(const glm::dvec3& from, const glm::dvec3& point) {
  const double x = point.x - from.x, y = point.y - from.y, z = point.z - from.z;
  return std::sqrt(x * x + y * y + z * z);
}

inline Interval distance(const glm::dvec3& from, const Bounds& box) {
  const auto [x, y, z] = relative(box, from);
  return norm(x, y, z);
}

/// Signed distance to a plane, positive on the side of its normal (eq. 2).
inline double signed_distance(const Plane& plane, const glm::dvec3& point) {
  const double x = point.x - plane.point.x, y = point.y - plane.point.y, z = point.z - plane.point.z;
  return x * plane.normal.x + y * plane.normal.y + z * plane.normal.z;
}

inline Interval signed_distance(const Plane& plane, const Bounds& box) {
  const auto [x, y, z] = relative(box, plane.point);
  return x * plane.normal.x + y * plane.normal.y + z * plane.normal.z;
}

/// The paper's own bound on the distance of a box to a ray (eq. 3): distance of the centre minus half the
/// diagonal. Never larger than project(ray, box).distance.low by more than rounding; kept because other
/// indices have spheres rather than boxes, and to measure what the tighter bound gains.
///
/// Centre and diagonal are not what a point's own distance is computed from, so this one needs an allowance.
/// With w the sum of |coordinate - origin| over the farther faces and u = 2^-53: the cross product and its
/// norm err by at most 10 u w for the point and as much for the centre, centre and half diagonal by 4 u w,
/// the direction's length by 1e-6 half diagonals; squares that underflow hide distances below 1e-153. Where
/// squares may overflow, the bound is 0.
inline double sphere_distance(const Ray& ray, const Bounds& box) {
  const auto [x, y, z] = relative(box, ray.origin);
  const double far = greatest_magnitude(x) + greatest_magnitude(y) + greatest_magnitude(z);
  if (!(far < 1e150)) return 0.0;
  const glm::dvec3 center = box.center();
  const glm::dvec3 half = box.max - center;
  const double half_diagonal = std::sqrt(half.x * half.x + half.y * half.y + half.z * half.z);
  // The centre is rounded in world coordinates, which may be much larger than `far`.
  const double rounding = 0x1p-52 * (std::fabs(center.x) + std::fabs(center.y) + std::fabs(center.z));
  const double allowance = 0x1p-47 * far + 4.0 * rounding + 1e-150;
  return std::max(0.0, project(ray, center).distance - (1.0 + 2e-6) * half_diagonal - allowance);
}

}  // namespace alidade
