// SPDX-License-Identifier: MIT
#include "database/postgres/cloud_limit.h"

#include <cmath>
#include <limits>

#include "database/point_filter.h"

namespace alidade {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

bool at_most(double a, double b) {
  return std::isnan(b) || a <= b;
}

bool is_finite(const glm::dvec3& place) {
  return std::isfinite(place.x) && std::isfinite(place.y) && std::isfinite(place.z);
}

/// Requires that something lies below: not -infinity.
double next_below(double value) {
  return std::isnan(value) ? k_infinity : std::nextafter(value, -k_infinity);
}

/// Requires that something lies above: not NaN.
double next_above(double value) {
  return value == k_infinity ? k_nan : std::nextafter(value, k_infinity);
}

}  // namespace

CloudLimit make_limit(DistanceKind kind, const CloudLine& line, Comparison comparison, double value) {
  CloudLimit limit{.line = line, .least = -k_infinity, .largest = k_nan, .kind = kind};
  const CloudLimit nothing{.line = line, .least = k_nan, .largest = -k_infinity, .kind = kind};
  switch (comparison) {
    case Comparison::less:
      if (value == -k_infinity) return nothing;
      limit.largest = next_below(value);
      break;
    case Comparison::less_equal:
      limit.largest = value;
      break;
    case Comparison::equal:
      limit.least = limit.largest = value;
      break;
    case Comparison::greater_equal:
      limit.least = value;
      break;
    case Comparison::greater:
      if (std::isnan(value)) return nothing;
      limit.least = next_above(value);
  }
  return limit;
}

bool holds(const CloudLimit& limit, const glm::dvec3& point) {
  const double value = distance(limit.kind, limit.line, point);
  return at_most(limit.least, value) && at_most(value, limit.largest);
}

bool is_finite(const Bounds& box) {
  return is_finite(box.min) && is_finite(box.max);
}

Bounds box_of(const glm::dvec3& point) {
  if (!is_finite(point)) return {glm::dvec3(-k_infinity), glm::dvec3(k_infinity)};
  return {point, point};
}

bool may_hold(const CloudLimit& limit, const Bounds& box) {
  // Distances that are not numbers come only of infinite ends and of what overflows. They keep a limit whose
  // end is NaN, which says more than an end at infinity where only one end of a plane's reach is no number.
  const auto end = [](double value) { return std::isnan(value) ? k_infinity : value; };
  const Interval limits{end(limit.least), end(limit.largest)};
  const CloudLine& line = limit.line;
  if (limit.kind == DistanceKind::plane && std::isnan(limit.largest)) {
    const Interval reach = distance(limit.kind, line, box);
    if (std::isnan(reach.low) || std::isnan(reach.high)) return true;
  }
  PointFilter filter;
  if (limit.kind == DistanceKind::ray)
    filter.lines.push_back({.ray = Ray{.origin = line.place, .direction = line.unit}, .distance = limits});
  else
    filter.planes.push_back({.plane = {line.place, line.unit}, .distance = limits});
  return may_hold(filter, box);
}

bool may_break(const CloudLimit& limit, const Bounds& box) {
  return may_hold(make_limit(limit.kind, limit.line, Comparison::less, limit.least), box) ||
         may_hold(make_limit(limit.kind, limit.line, Comparison::greater, limit.largest), box);
}

}  // namespace alidade
