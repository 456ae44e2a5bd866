// SPDX-License-Identifier: MIT
#include "tools/query/target_bounds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>

namespace alidade {
namespace {

/// More than rounding moves a coordinate of these numbers by.
double margin_of(std::initializer_list<glm::dvec3> places, double radius) {
  constexpr double k_share = 1e-9;
  double largest = radius;
  for (const glm::dvec3& place : places)
    largest = std::max({largest, std::fabs(place.x), std::fabs(place.y), std::fabs(place.z)});
  return k_share * largest;
}

Bounds widened(const Bounds& box, double by) {
  return box.empty() ? box : Bounds{box.min - by, box.max + by};
}

/// The part of the interval on t in which the axis lies in the box; inverted if there is none.
void clip(const Ray& axis, const Bounds& box, double& t_min, double& t_max) {
  for (int i = 0; i < 3; ++i) {
    const double low = box.min[i] - axis.origin[i], high = box.max[i] - axis.origin[i];
    if (axis.direction[i] == 0.0) {
      if (low > 0.0 || high < 0.0) t_max = -std::numeric_limits<double>::infinity();
      continue;
    }
    const double a = low / axis.direction[i], b = high / axis.direction[i];
    t_min = std::max(t_min, std::min(a, b));
    t_max = std::min(t_max, std::max(a, b));
  }
}

}  // namespace

Bounds target_bounds(const Ray& ray, double radius, const Bounds& within) {
  if (within.empty() || !(ray.t_min <= ray.t_max)) return {};
  // A point in the box has its foot on the ray at most `radius` outside of it.
  const double margin = margin_of({ray.origin, within.min, within.max}, radius);
  double t_min = ray.t_min, t_max = ray.t_max;
  clip(ray, widened(within, radius + margin), t_min, t_max);
  if (t_min > t_max) return {};
  Bounds bounds;
  bounds.grow(ray.position(t_min));
  bounds.grow(ray.position(t_max));
  return widened(bounds, radius + margin);
}

Bounds target_bounds(const Cone& cone, double, const Bounds& within) {
  if (within.empty()) return {};
  // The farthest place along the axis that a point can project to is that of a corner; there the cone is
  // widest.
  Ray axis = cone.axis;
  double farthest = -std::numeric_limits<double>::infinity();
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 place{(corner & 1) ? within.max.x : within.min.x,
                           (corner & 2) ? within.max.y : within.min.y,
                           (corner & 4) ? within.max.z : within.min.z};
    farthest = std::max(farthest, glm::dot(place - axis.origin, axis.direction));
  }
  axis.t_max = std::min(axis.t_max, farthest + margin_of({axis.origin, within.min, within.max}, 0.0));
  const double widest = cone.limit(axis.t_max);
  if (!(widest >= 0.0)) return {};
  return target_bounds(axis, widest, within);
}

Bounds target_bounds(const Path& path, double radius, const Bounds&) {
  Bounds bounds;
  for (const glm::dvec3& vertex : path.vertices) bounds.grow(vertex);
  return widened(bounds, radius + margin_of({bounds.min, bounds.max}, radius));
}

Bounds target_bounds(const HalfSpaces&, double, const Bounds& within) {
  return within;
}

Bounds target_bounds(const Bounds& box, double, const Bounds&) {
  return box;
}

Bounds target_bounds(const glm::dvec3& place, double radius, const Bounds&) {
  return widened({place, place}, radius + margin_of({place}, radius));
}

}  // namespace alidade
