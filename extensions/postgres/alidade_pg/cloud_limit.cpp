// SPDX-License-Identifier: MIT
#include "extensions/postgres/alidade_pg/cloud_limit.h"

#include <algorithm>
#include <limits>

namespace alidade::database {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

bool at_most(double a, double b) {
  return std::isnan(b) || a <= b;
}

/// The next smaller number. Requires a value above -infinity.
double next_below(double value) {
  return std::isnan(value) ? k_infinity : std::nextafter(value, -k_infinity);
}

/// The next greater number in PostgreSQL's order. Requires a value other than NaN.
double next_above(double value) {
  return value == k_infinity ? k_nan : std::nextafter(value, k_infinity);
}

constexpr std::size_t k_counted = 8;

/// Share of distances that are at most `value`.
double share_up_to(double value, std::span<const double> distances, DistanceKind kind) {
  if (std::isnan(value)) return 1.0;
  const auto count = static_cast<double>(distances.size());
  const auto above = static_cast<std::size_t>(
      std::ranges::upper_bound(distances, value,
                               [](double a, double b) { return compare_numbers(a, b) < 0; }) -
      distances.begin());
  const std::size_t counted = std::min(k_counted, distances.size());
  if (kind == DistanceKind::ray && above < counted) {
    const double anchor = distances[counted - 1];
    if (!(anchor > 0.0) || !(value > 0.0)) return 0.0;
    return static_cast<double>(counted) / count * (value / anchor) * (value / anchor);
  }
  if (above == 0) return 0.0;
  if (above == distances.size()) return 1.0;
  const double low = distances[above - 1], high = distances[above];
  const double part = high - low < HUGE_VAL ? (value - low) / (high - low) : 0.0;
  return (static_cast<double>(above) + part) / count;
}

}  // namespace

CloudLimit make_limit(DistanceKind kind, const CloudLine& line, Comparison comparison, double value) {
  CloudLimit limit{.line = line, .least = -k_infinity, .largest = k_nan, .kind = kind};
  const CloudLimit nothing{.line = line, .least = k_nan, .largest = -k_infinity, .kind = kind};
  if (comparison == Comparison::less && value == -k_infinity) return nothing;
  if (comparison == Comparison::greater && std::isnan(value)) return nothing;
  if (comparison <= Comparison::equal)
    limit.largest = comparison == Comparison::less ? next_below(value) : value;
  if (comparison >= Comparison::equal)
    limit.least = comparison == Comparison::greater ? next_above(value) : value;
  return limit;
}

bool holds(const CloudLimit& limit, const glm::dvec3& point) {
  const double value = distance(limit.kind, limit.line, point);
  return at_most(limit.least, value) && at_most(value, limit.largest);
}

bool is_finite(const Bounds& box) {
  return alidade::is_finite(box.min) && alidade::is_finite(box.max);
}

Bounds box_of(const glm::dvec3& point) {
  if (!alidade::is_finite(point)) return {glm::dvec3(-k_infinity), glm::dvec3(k_infinity)};
  return {point, point};
}

bool may_hold(const CloudLimit& limit, const Bounds& box) {
  // Distances are NaN only for infinite ends and after overflow. Such points are within a limit whose end is
  // NaN, which is tighter than an end at infinity if only one end of a plane's reach is NaN.
  const auto end = [](double value) { return std::isnan(value) ? k_infinity : value; };
  const Interval limits{end(limit.least), end(limit.largest)};
  if (limit.kind == DistanceKind::plane && std::isnan(limit.largest)) {
    const Interval reach = distance(limit.kind, limit.line, box);
    if (std::isnan(reach.low) || std::isnan(reach.high)) return true;
  }
  PointFilter filter;
  filter.add(limit.kind, limit.line, limits);
  return may_hold(filter, box);
}

bool may_break(const CloudLimit& limit, const Bounds& box) {
  return may_hold(make_limit(limit.kind, limit.line, Comparison::less, limit.least), box) ||
         may_hold(make_limit(limit.kind, limit.line, Comparison::greater, limit.largest), box);
}

double estimated_share(const CloudLimit& limit, std::span<const double> distances) {
  if (compare_numbers(limit.least, limit.largest) > 0) return 0.0;
  const double share =
      share_up_to(limit.largest, distances, limit.kind) - share_up_to(limit.least, distances, limit.kind);
  return std::clamp(share, 0.0, 1.0);
}

}  // namespace alidade::database
