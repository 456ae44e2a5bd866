// SPDX-License-Identifier: MIT
#include "octree/check_query.h"

#include <fmt/format.h>

#include <cmath>

#include "octree/octree.h"
#include "octree/path_index.h"

namespace alidade {
namespace {

constexpr double k_length_tolerance = 1e-6;

template <class Found>
void require(bool holds, const char* problem, const char* expected, const Found& found) {
  if (!holds) throw Error({.problem = problem, .expected = expected, .found = fmt::format("{}", found)});
}

void check_k(std::size_t k, int max_level) {
  if (k == 0) throw Error({.problem = "k is 0", .expected = "at least 1"});
  require(max_level >= 0, "max_level is negative", "at least 0", max_level);
}

void check_radius(double radius) {
  require(radius >= 0.0, "radius out of range", "at least 0", radius);
}

void check_position(const glm::dvec3& position, const char* what) {
  if (!is_finite(position))
    throw Error({.problem = fmt::format("{} is not finite", what), .found = text_of(position)});
}

/// NaN and infinite components do not pass either.
void check_unit(const glm::dvec3& direction, const char* what) {
  const double square = direction.x * direction.x + direction.y * direction.y + direction.z * direction.z;
  if (std::fabs(std::sqrt(square) - 1.0) <= k_length_tolerance) return;
  throw input_error(fmt::format("{} is not normalized", what), "a unit vector", text_of(direction));
}

void check_interval(double t_min, double t_max) {
  if (std::isnan(t_min) || std::isnan(t_max)) throw Error({.problem = "a limit of the interval is NaN"});
}

void check_width(double width, const char* problem) {
  require(width >= 0.0 && std::isfinite(width), problem, "a finite number, at least 0", width);
}

}  // namespace

std::string text_of(const glm::dvec3& v) {
  return fmt::format("({}, {}, {})", v.x, v.y, v.z);
}

void check_radius_along_ray(double radius, Measure measure, double entry_min) {
  check_radius(radius);
  if (std::isnan(entry_min)) throw Error({.problem = "entry_min is NaN"});
  require(measure != Measure::entry || !std::isinf(radius), "measure entry requires a radius",
          "a finite radius, or measure t or distance", "none");
}

void check(const RayQuery& query) {
  check_k(query.k, query.max_level);
  check_radius_along_ray(query.radius, query.measure, query.entry_min);
}

void check(const ConeQuery& query) {
  check_k(query.k, query.max_level);
}

void check(const PathQuery& query) {
  check_k(query.k, query.max_level);
  check_radius(query.radius);
  if (query.measure == Measure::entry)
    throw Error({.problem = "paths do not support measure entry", .expected = "t or distance"});
}

void check(const PointQuery& query) {
  check_k(query.k, query.max_level);
  check_radius(query.radius);
}

void check_without_radius(const PointQuery& query) {
  check(query);
  require(std::isinf(query.radius), "box and half-space queries do not support a radius", "none",
          query.radius);
}

void check(const Ray& ray) {
  check_position(ray.origin, "the origin");
  check_unit(ray.direction, "the direction");
  check_interval(ray.t_min, ray.t_max);
}

void check(const Cone& cone) {
  check(cone.axis);
  check_width(cone.radius, "cone radius out of range");
  check_width(cone.slope, "cone slope out of range");
}

void check(const Path& path) {
  require(path.vertices.size() >= 2, "too few path vertices", "at least 2", path.vertices.size());
  if (path.vertex_t.size() != path.vertices.size()) {
    throw input_error("wrong number of t values in the path", fmt::format("{}", path.vertices.size()),
                      fmt::format("{}", path.vertex_t.size()));
  }
  check_interval(path.t_min, path.t_max);
  for (const glm::dvec3& vertex : path.vertices) check_position(vertex, "a vertex");
  bool follows = path.vertex_t[0] == 0.0;
  for (std::size_t i = 0; follows && i + 1 < path.vertices.size(); ++i) {
    const double length = length_of(path.vertices[i + 1] - path.vertices[i]);
    follows = length > 0.0 && std::isfinite(length) && path.vertex_t[i + 1] == path.vertex_t[i] + length;
  }
  if (!follows || !std::isfinite(path.vertex_t.back()))
    throw input_error("vertex_t is not the length along the path", "a path from make_path");
}

void check(const HalfSpaces& region) {
  for (const Plane& plane : region.planes) {
    check_position(plane.point, "the point of a plane");
    check_unit(plane.normal, "the normal of a plane");
  }
}

void check(const Bounds& box) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isnan(box.min[axis]) || std::isnan(box.max[axis]))
      throw Error({.problem = "a face of the box is NaN"});
  }
}

void check(const glm::dvec3& point) {
  check_position(point, "the point");
}

void check_level(const Octree& octree, int max_level) {
  if (octree.size() > 0 && max_level != k_all_levels && octree.view().organisation != Organisation::layered)
    throw Error({.problem = "max_level requires a layered octree", .expected = "Organisation::layered"});
}

void check_room(std::size_t targets, std::size_t room) {
  if (targets == room) return;
  throw input_error("the span of answers does not match the targets", fmt::format("{}", targets),
                    fmt::format("{}", room));
}

}  // namespace alidade
