// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

namespace alidade {

/// Number of the cell of 2^-20 units in which a coordinate lies. Coordinates farther away than 2^43 units lie
/// in the first and last; what is not a number lies in the last.
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

/// Order along the z-order curve of cells (octree/morton.h, without making keys, which would have 192 bits),
/// within a cell by x, y and z. Zero only for equal coordinates.
inline int compare_morton(const glm::dvec3& a, const glm::dvec3& b) {
  // The axis with the highest bit in which the cells differ decides; of several the last, as in the key.
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

}  // namespace alidade
