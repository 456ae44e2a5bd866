// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/huge_memory.h"
#include "cloud/lattice.h"
#include "octree/building/sort_entry.h"
#include "octree/morton.h"

namespace alidade {

/// Where a cloud's positions lie.
struct KeySpace {
  LatticePosition base{0};  ///< lowest lattice position on each axis
  int extent_bits = 0;      ///< bits that hold the largest step count from base; 0 .. 32

  /// Whether NarrowEntry holds the positions.
  bool is_narrow() const { return extent_bits <= k_morton_bits; }
};

/// Cost: one pass, in parallel.
KeySpace key_space(const std::vector<LatticePosition>& positions);

/// One in which positions have the order that they have in the space of all positions, and so in any that
/// this function gives: pieces of a cloud that were sorted apart can be merged. Cost: one pass, in parallel.
KeySpace aligned_key_space(const std::vector<LatticePosition>& positions);

/// Points in (Morton key, id) order.
template <class Entry>
class SortedPoints {
 public:
  explicit SortedPoints(std::size_t size)
      : entries_(size), release_(entries_.data(), size * sizeof(Entry), k_release_block) {}

  std::size_t size() const { return entries_.size(); }
  Entry* data() { return entries_.data(); }
  const Entry& operator[](std::size_t i) const { return entries_[i]; }

  /// These entries will not be read again: their memory goes back to the system when all around them is used
  /// up too. Each entry at most once; from many threads.
  void use_up(std::size_t begin, std::size_t end) {
    release_.use_up(begin * sizeof(Entry), (end - begin) * sizeof(Entry));
  }

 private:
  static constexpr std::size_t k_release_block = std::size_t{1} << 21;
  HugeArray<Entry> entries_;
  PageRelease release_;
};

/// Sorts points by Morton key, then row, in parallel; the result does not depend on the number of threads.
/// Requires fewer than 2^32 positions, and space.is_narrow() for NarrowEntry. Cost: a few passes over the
/// points, whatever their distribution. Memory at the peak: two entries per point beside the positions.
template <class Entry>
SortedPoints<Entry> sort_points(const KeySpace& space, const std::vector<LatticePosition>& positions);

/// The same, using up the positions, which are empty afterwards. Memory at the peak, that of the positions
/// included: one narrow or two wide entries per point.
template <class Entry>
SortedPoints<Entry> sort_points(const KeySpace& space, std::vector<LatticePosition>&& positions);

}  // namespace alidade
