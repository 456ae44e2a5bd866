// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "cloud/lattice.h"
#include "octree/morton.h"

namespace alidade {

/// Where a place lies along the Morton curve.
inline WideMortonKey morton_key_of(const LatticePosition& position) {
  constexpr std::uint32_t k_lowest = 0x80000000u;
  return wide_morton_key(static_cast<std::uint32_t>(position.x) ^ k_lowest,
                         static_cast<std::uint32_t>(position.y) ^ k_lowest,
                         static_cast<std::uint32_t>(position.z) ^ k_lowest);
}

/// The rows of a cloud along that curve, which is the same for all clouds; rows at one place as they were.
/// Requires fewer than 2^32. Memory at the peak: 36 bytes per row.
std::vector<std::uint32_t> morton_order(const std::vector<LatticePosition>& positions);

}  // namespace alidade
