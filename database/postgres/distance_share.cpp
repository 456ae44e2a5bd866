// SPDX-License-Identifier: MIT
#include "database/postgres/distance_share.h"

#include <algorithm>
#include <cmath>

#include "database/postgres/point_order.h"

namespace alidade {
namespace {

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

double estimated_share(const CloudLimit& limit, std::span<const double> distances) {
  if (compare_numbers(limit.least, limit.largest) > 0) return 0.0;
  const double share =
      share_up_to(limit.largest, distances, limit.kind) - share_up_to(limit.least, distances, limit.kind);
  return std::clamp(share, 0.0, 1.0);
}

}  // namespace alidade
