// SPDX-License-Identifier: MIT
#include "database/server/filter_condition.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace alidade {
namespace {

constexpr const char* k_never = "false";

/// The largest of some coordinates, none of them NaN.
double reach(const glm::dvec3& place) {
  return std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)});
}

/// Numbers are written such that reading gives the same ones.
std::string number(double value) {
  return fmt::format("'{}'::float8", value);
}

std::string call(const char* function, const glm::dvec3& origin, const glm::dvec3& direction) {
  std::string text = function;
  text += "(";
  for (const glm::dvec3& three : {origin, direction}) {
    for (int axis = 0; axis < 3; ++axis) text += number(three[axis]) + ",";
  }
  return text + "x,y,z)";
}

/// Adds the limits that say something about what is `least` or more.
void add_limits(const std::string& value, const Interval& limits, double size, double least,
                std::vector<std::string>& all) {
  if (std::isnan(limits.low) || std::isnan(limits.high) || limits.low > limits.high) {
    all.emplace_back(k_never);
    return;
  }
  const auto margin = [&](double limit) { return 1e-9 * std::abs(limit) + 1e-9 + 1e-12 * size; };
  const double low = limits.low - margin(limits.low), high = limits.high + margin(limits.high);
  // Infinite limits make NaN of their margins, or stay infinite: of the former kind are those that exclude
  // every point.
  if (limits.low == std::numeric_limits<double>::infinity() ||
      limits.high == -std::numeric_limits<double>::infinity()) {
    all.emplace_back(k_never);
    return;
  }
  if (limits.low > -std::numeric_limits<double>::infinity() && low > least)
    all.push_back(value + " >= " + number(low));
  if (limits.high < std::numeric_limits<double>::infinity()) all.push_back(value + " <= " + number(high));
}

std::string condition(const PointFilter& filter) {
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  std::vector<std::string> all;
  for (const LineCondition& line : filter.lines) {
    const glm::dvec3& origin = line.ray.origin;
    const glm::dvec3& direction = line.ray.direction;
    add_limits(call("dist_ray", origin, direction), line.distance, reach(origin), 0.0, all);
    add_limits(call("dist_plane", origin, direction), line.t, reach(origin), -k_infinity, all);
  }
  for (const PlaneCondition& plane : filter.planes) {
    add_limits(call("dist_plane", plane.plane.point, plane.plane.normal), plane.distance,
               reach(plane.plane.point), -k_infinity, all);
  }
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 normal(0.0);
    normal[axis] = 1.0;
    const Interval side{filter.box.min[axis], filter.box.max[axis]};
    const double size = std::max(std::isfinite(side.low) ? std::abs(side.low) : 0.0,
                                 std::isfinite(side.high) ? std::abs(side.high) : 0.0);
    // The plane through the coordinates' origin: its distances are the coordinates.
    add_limits(call("dist_plane", glm::dvec3(0.0), normal), side, size, -k_infinity, all);
  }
  return all.empty() ? "true" : fmt::format("({})", fmt::join(all, " AND "));
}

}  // namespace

std::string filter_condition(std::span<const PointFilter> any_of) {
  std::vector<std::string> all;
  for (const PointFilter& filter : any_of) all.push_back(condition(filter));
  return all.empty() ? k_never : fmt::format("{}", fmt::join(all, " OR "));
}

}  // namespace alidade
