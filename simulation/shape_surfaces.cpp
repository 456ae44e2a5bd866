// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "simulation/intersect_ground.h"
#include "simulation/shapes.h"

namespace alidade::shapes {

namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

glm::dvec3 normal_of(const Polygon& polygon) {
  return glm::normalize(
      glm::cross(polygon.corners[1] - polygon.corners[0], polygon.corners[2] - polygon.corners[0]));
}

SurfacePoint surface_of(const Sphere& sphere, const glm::dvec3& position) {
  return {glm::normalize(position - sphere.center), {}, 0};
}

SurfacePoint surface_of(const Ellipsoid& ellipsoid, const glm::dvec3& position) {
  return {glm::normalize((position - ellipsoid.center) / (ellipsoid.radii * ellipsoid.radii)), {}, 0};
}

SurfacePoint surface_of(const Frustum& frustum, const glm::dvec3& position) {
  const glm::dvec3 from_base = position - frustum.base;
  const double height = glm::dot(from_base, frustum.axis);
  const glm::dvec3 outward = glm::normalize(from_base - height * frustum.axis);
  const double taper = (frustum.top_radius - frustum.base_radius) / frustum.length;
  return {glm::normalize(outward - taper * frustum.axis), {0.0, height}, 0};
}

SurfacePoint surface_of(const Disc& disc, const glm::dvec3& position) {
  return {disc.normal, {glm::length(position - disc.center), 0.0}, 0};
}

SurfacePoint surface_of(const Box& box, const glm::dvec3& position) {
  const glm::dvec3 place = (position - box.center) * box.axes;
  int axis = 0;
  double closest = k_infinity;
  for (int i = 0; i < 3; ++i) {
    const double gap = std::fabs(box.half_size[i] - std::fabs(place[i]));
    if (gap < closest) closest = gap, axis = i;
  }
  const bool positive = place[axis] > 0.0;
  const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
  return {positive ? box.axes[axis] : -box.axes[axis],
          {place[first] + box.half_size[first], place[second] + box.half_size[second]},
          2 * axis + (positive ? 1 : 0)};
}

SurfacePoint surface_of(const Niche& niche, const glm::dvec3& position) {
  const Box& box = niche.box;
  const glm::dvec3 place = (position - box.center) * box.axes;
  const double gaps[] = {std::fabs(box.half_size.x - std::fabs(place.x)),
                         std::fabs(box.half_size.y - std::fabs(place.y)),
                         std::fabs(box.half_size.z + place.z)};
  const int axis = static_cast<int>(std::min_element(gaps, gaps + 3) - gaps);
  const bool positive = axis != 2 && place[axis] > 0.0;
  const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
  return {positive ? -box.axes[axis] : box.axes[axis],
          {place[first] + box.half_size[first], place[second] + box.half_size[second]},
          2 * axis + (positive ? 1 : 0)};
}

SurfacePoint surface_of(const Panel& panel, const glm::dvec3& position) {
  const glm::dvec3 from_corner = position - panel.corner;
  return {glm::cross(panel.u_axis, panel.v_axis),
          {glm::dot(from_corner, panel.u_axis), glm::dot(from_corner, panel.v_axis)},
          0};
}

SurfacePoint surface_of(const Polygon& polygon, const glm::dvec3&) {
  return {normal_of(polygon), {}, 0};
}

SurfacePoint surface_of(const ConvexSolid& solid, const glm::dvec3& position) {
  std::size_t nearest = 0;
  double closest = k_infinity;
  for (std::size_t i = 0; i < solid.sides.size(); ++i) {
    const double gap = std::fabs(solid.sides[i].offset - glm::dot(position, solid.sides[i].normal));
    if (gap < closest) closest = gap, nearest = i;
  }
  return {solid.sides[nearest].normal, {}, static_cast<int>(nearest)};
}

SurfacePoint surface_of(const Ground& ground, const glm::dvec3& position) {
  const glm::dvec2 place(position.x, position.y);
  const GroundHeight height = height_at(ground, place);
  int face = 0;
  for (const Patch& patch : ground.patches) {
    const glm::dvec2 offset = (place - patch.center) / patch.half_size;
    const bool covers = patch.round ? glm::dot(offset, offset) <= 1.0
                                    : std::fabs(offset.x) <= 1.0 && std::fabs(offset.y) <= 1.0;
    if (covers) face = patch.face;
  }
  return {glm::normalize(glm::dvec3(-height.slope.x, -height.slope.y, 1.0)), place, face};
}

/// Around a flat circle.
Bounds bounds_of_circle(const glm::dvec3& center, const glm::dvec3& normal, double radius) {
  glm::dvec3 reach;
  for (int axis = 0; axis < 3; ++axis)
    reach[axis] = radius * std::sqrt(std::max(0.0, 1.0 - normal[axis] * normal[axis]));
  return {center - reach, center + reach};
}

Bounds bounds_of_shape(const Sphere& sphere) {
  return {sphere.center - sphere.radius, sphere.center + sphere.radius};
}
Bounds bounds_of_shape(const Ellipsoid& body) {
  return {body.center - body.radii, body.center + body.radii};
}
Bounds bounds_of_shape(const Frustum& frustum) {
  Bounds bounds = bounds_of_circle(frustum.base, frustum.axis, frustum.base_radius);
  bounds.grow(
      bounds_of_circle(frustum.base + frustum.length * frustum.axis, frustum.axis, frustum.top_radius));
  return bounds;
}
Bounds bounds_of_shape(const Disc& disc) {
  return bounds_of_circle(disc.center, disc.normal, disc.radius);
}
Bounds bounds_of_shape(const Box& box) {
  const glm::dvec3 reach = glm::abs(box.axes[0]) * box.half_size.x + glm::abs(box.axes[1]) * box.half_size.y +
                           glm::abs(box.axes[2]) * box.half_size.z;
  return {box.center - reach, box.center + reach};
}
Bounds bounds_of_shape(const Niche& niche) {
  return bounds_of_shape(niche.box);
}
Bounds bounds_of_shape(const Panel& panel) {
  Bounds bounds;
  for (const double u : {0.0, panel.size.x})
    for (const double v : {0.0, panel.size.y})
      bounds.grow(panel.corner + u * panel.u_axis + v * panel.v_axis);
  return bounds;
}
Bounds bounds_of_shape(const Polygon& polygon) {
  Bounds bounds;
  for (const glm::dvec3& corner : polygon.corners) bounds.grow(corner);
  return bounds;
}
Bounds bounds_of_shape(const ConvexSolid& solid) {
  return solid.bounds;
}
Bounds bounds_of_shape(const Ground& ground) {
  const double reach = amplitude_of(ground);
  return {{-ground.half_size.x, -ground.half_size.y, -reach},
          {ground.half_size.x, ground.half_size.y, reach}};
}

}  // namespace

SurfacePoint surface_at(const Shape& shape, const glm::dvec3& position) {
  return std::visit([&](const auto& any) { return surface_of(any, position); }, shape);
}

Bounds bounds_of(const Shape& shape) {
  return std::visit([](const auto& any) { return bounds_of_shape(any); }, shape);
}

}  // namespace alidade::shapes
