// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/bounds.h"
#include "base/morton.h"
#include "octree/simd/sort_keys.h"

namespace alidade {

/// Brings targets, given by their numbers in the lower halves, into an order in which each is near the one
/// before. position(number): of a target.
template <class Position>
void sort_along_curve(const Position& position, std::vector<simd::SortKey>& numbers) {
  constexpr int k_bits = 10;
  Bounds bounds;
  for (const simd::SortKey key : numbers) bounds.grow(position(simd::number_of(key)));
  const glm::dvec3 size = bounds.size();
  const double widest = std::max({size.x, size.y, size.z});
  constexpr double k_least = 1e-290;  // its inverse times any number of cells is finite
  if (!(widest >= k_least) || std::isinf(widest)) return;
  const double cells = ((1 << k_bits) - 1) / widest;
  for (simd::SortKey& key : numbers) {
    const glm::dvec3 cell = (position(simd::number_of(key)) - bounds.min) * cells;
    key = simd::number_of(key) |
          morton_key(static_cast<std::uint32_t>(cell.x), static_cast<std::uint32_t>(cell.y),
                     static_cast<std::uint32_t>(cell.z))
              << 32;
  }
  simd::sort_keys(numbers);
}

}  // namespace alidade
