// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "database/point_filter.h"

namespace alidade::database {

enum class Comparison { less, less_equal, equal, greater_equal, greater };

/// A limit on dist_ray or dist_plane: the value of the SQL type cloud_limit, byte for byte. Distances are
/// ordered as PostgreSQL orders them: NaN equals itself and is above all others.
struct CloudLimit {
  CloudLine line;
  double least, largest;  ///< inclusive; no distance is within if least is above largest
  DistanceKind kind;
};

/// The limit that is equivalent to `distance comparison value`, to the last bit.
CloudLimit make_limit(DistanceKind kind, const CloudLine& line, Comparison comparison, double value);

/// Whether the distance of a point is within a limit.
bool holds(const CloudLimit& limit, const glm::dvec3& point);

/// False only if no point of the box is within the limit. An unbounded box also has points without a
/// position.
bool may_hold(const CloudLimit& limit, const Bounds& box);

/// False only if all points of the box are within the limit.
bool may_break(const CloudLimit& limit, const Bounds& box);

/// Whether all faces are finite.
bool is_finite(const Bounds& box);

/// The box of a point; unbounded if a coordinate is not finite.
Bounds box_of(const glm::dvec3& point);

/// Number of the cell of 2^-20 units in which a coordinate lies. Coordinates farther away than 2^43 units are
/// in the first and last cells, NaN is in the last.
inline std::uint64_t morton_cell(double coordinate) {
  const double cell = std::floor(coordinate * 0x1p20);
  if (!(cell < 0x1p63)) return ~std::uint64_t{0};
  if (cell < -0x1p63) return 0;
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(cell)) ^ std::uint64_t{1} << 63;
}

/// Compares numbers as PostgreSQL does, NaN above all: negative, zero or positive.
inline int compare_numbers(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return (std::isnan(a) ? 1 : 0) - (std::isnan(b) ? 1 : 0);
  return a < b ? -1 : a > b ? 1 : 0;
}

/// Order along the z-order curve of cells (base/morton.h, without making keys, which would have 192 bits),
/// within a cell by x, y and z. Zero only for equal coordinates.
inline int compare_morton(const glm::dvec3& a, const glm::dvec3& b) {
  // The axis with the highest bit in which the cells differ decides; of several such axes the last, as in the
  // key.
  std::uint64_t highest = 0, first = 0, second = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t from = morton_cell(a[axis]), to = morton_cell(b[axis]), difference = from ^ to;
    const bool is_lower = difference < highest && difference < (difference ^ highest);
    if (difference == 0 || is_lower) continue;
    highest = difference;
    first = from;
    second = to;
  }
  if (highest != 0) return first < second ? -1 : 1;
  for (int axis = 0; axis < 3; ++axis)
    if (const int order = compare_numbers(a[axis], b[axis])) return order;
  return 0;
}

/// Estimates the share of all points that are within a limit, in [0, 1], from the distances of a sample, in
/// ascending order (NaN last): between the sample's distances the share grows linearly. Near a ray the sample
/// has too few points: below the distance of its eighth point the share grows with the square of the
/// distance, as the cross-section of the cylinder does. Requires a sample that is not empty.
double estimated_share(const CloudLimit& limit, std::span<const double> distances);

}  // namespace alidade::database
