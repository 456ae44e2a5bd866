// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "octree/cloud/lattice.h"
#include "octree/morton.h"

namespace alidade {

/// A point under way into the octree: Morton key and row, 12 bytes.
struct SortEntry {
  std::uint32_t key_low;
  std::uint32_t key_high;
  std::uint32_t id;

  std::uint64_t key() const { return std::uint64_t{key_high} << 32 | key_low; }
};
static_assert(sizeof(SortEntry) == 12);

/// Points in Morton order.
struct SortedPoints {
  LatticePosition base{0};  ///< lowest lattice position on each axis
  int extent_bits = 0;      ///< bits that hold the largest step count from base
  int key_shift = 0;        ///< key coordinates are steps >> key_shift; 0 = keys hold positions without loss
  std::size_t count = 0;
  std::unique_ptr<SortEntry[]> entries;
};

/// Sorts by (Morton key, id), in parallel; the result does not depend on the number of threads.
/// At most 2^32 - 1 positions. Memory: 12 bytes per point. If keys hold the positions without loss (extents
/// below 2^21 steps), `released` (null, or the very vector) is emptied as soon as it is not needed any more:
/// before sorting.
SortedPoints sort_points(const std::vector<LatticePosition>& positions,
                         std::vector<LatticePosition>* released);

}  // namespace alidade
