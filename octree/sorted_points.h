// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "octree/cloud/lattice.h"
#include "octree/morton.h"

namespace alidade {

/// A point under way into the octree: Morton key and row. As large as the position it takes the place of.
struct SortEntry {
  std::uint32_t key_low;
  std::uint32_t key_high;
  std::uint32_t id;

  std::uint64_t key() const { return std::uint64_t{key_high} << 32 | key_low; }
};
static_assert(sizeof(SortEntry) == sizeof(LatticePosition));

/// Where a cloud's positions lie, and how keys are made of them.
struct KeySpace {
  LatticePosition base{0};  ///< lowest lattice position on each axis
  int extent_bits = 0;      ///< bits that hold the largest step count from base
  int key_shift = 0;        ///< key coordinates are steps >> key_shift; 0 = keys hold positions without loss
};

/// Cost: one pass, in parallel.
KeySpace key_space(const std::vector<LatticePosition>& positions);

/// Points in (Morton key, id) order.
class SortedPoints {
 public:
  SortedPoints(const KeySpace& space, std::vector<LatticePosition> packed)
      : space_(space), packed_(std::move(packed)) {}

  const KeySpace& space() const { return space_; }
  std::size_t size() const { return packed_.size(); }
  SortEntry operator[](std::size_t i) const { return std::bit_cast<SortEntry>(packed_[i]); }

  /// Gives the memory of these entries back to the system as far as it fills whole pages; they must not be
  /// read again. May be called for different ranges from several threads.
  void discard(std::size_t begin, std::size_t end);

 private:
  KeySpace space_;
  std::vector<LatticePosition> packed_;  ///< SortEntry by SortEntry, in the memory of the positions
};

/// Sorts in the memory of `positions`, in parallel; the result does not depend on the number of threads.
/// At most 2^32 - 1 positions.
SortedPoints sort_points(const KeySpace& space, std::vector<LatticePosition> positions);

}  // namespace alidade
