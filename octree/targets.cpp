// SPDX-License-Identifier: MIT
#include "octree/targets.h"

#include <fmt/format.h>

#include "base/error.h"

namespace alidade {

Cone make_cone(const glm::dvec3& apex, const glm::dvec3& direction, double half_angle, double radius,
               double t_min, double t_max) {
  constexpr double k_right_angle = 1.5707963267948966;
  if (!(half_angle >= 0.0 && half_angle < k_right_angle)) {
    throw input_error("cone half angle out of range", "at least 0 and less than pi / 2",
                      fmt::format("{}", half_angle));
  }
  if (!(radius >= 0.0 && std::isfinite(radius)))
    throw input_error("cone radius out of range", "a finite number, at least 0", fmt::format("{}", radius));
  return {make_ray(apex, direction, t_min, t_max), radius, std::tan(half_angle)};
}

Plane make_plane(const glm::dvec3& point, const glm::dvec3& normal) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(point[axis])) throw Error({.problem = "the point of a plane is not finite"});
    if (!std::isfinite(normal[axis])) throw Error({.problem = "the normal of a plane is not finite"});
  }
  if (normal == glm::dvec3(0.0)) throw Error({.problem = "the normal of a plane is zero"});
  return {point, unit_direction(normal)};
}

HalfSpaces make_slab(const Plane& plane, double thickness) {
  if (!(thickness >= 0.0 && std::isfinite(thickness)))
    throw input_error("slab thickness out of range", "a finite number, at least 0",
                      fmt::format("{}", thickness));
  return {{plane, {plane.point + thickness * plane.normal, -plane.normal}}};
}

Path make_path(const std::vector<glm::dvec3>& vertices, double t_min, double t_max) {
  if (std::isnan(t_min) || std::isnan(t_max))
    throw Error({.problem = "a limit of the path's interval is NaN"});
  Path path{.vertices = {}, .vertex_t = {}, .t_min = t_min, .t_max = t_max};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const glm::dvec3& vertex = vertices[i];
    if (!is_finite(vertex)) throw Error({.problem = fmt::format("path vertex {} is not finite", i)});
    if (path.vertices.empty()) {
      path.vertex_t.push_back(0.0);
    } else {
      const double length = length_of(vertex - path.vertices.back());
      if (length == 0.0) continue;
      path.vertex_t.push_back(path.vertex_t.back() + length);
    }
    path.vertices.push_back(vertex);
  }
  if (path.vertices.size() < 2)
    throw input_error("too few distinct path vertices", "at least 2",
                      fmt::format("{}", path.vertices.size()));
  if (!std::isfinite(path.vertex_t.back())) throw Error({.problem = "the path length overflows"});
  return path;
}

}  // namespace alidade
