// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/huge_memory.h"
#include "base/morton.h"
#include "base/scratch_file.h"
#include "cloud/lattice.h"

namespace alidade {

/// Lattice steps from the lowest position of a cloud, per axis.
using Steps = glm::uvec3;

/// A point while the octree is built: Morton key, which contains its position without loss, and row. As large
/// as the position that it replaces; for clouds of at most 2^21 steps per axis.
struct NarrowEntry {
  using Key = std::uint64_t;

  std::uint32_t key_low;
  std::uint32_t key_high;
  std::uint32_t id;

  static NarrowEntry make(const Steps& steps, std::uint32_t id) {
    const Key key = morton_key(steps[0], steps[1], steps[2]);
    return {static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(key >> 32), id};
  }
  Key key() const { return Key{key_high} << 32 | key_low; }
};
static_assert(sizeof(NarrowEntry) == sizeof(LatticePosition));

/// An entry for clouds of any extent, which is larger than a NarrowEntry.
struct WideEntry {
  using Key = WideMortonKey;

  std::uint64_t key_high;
  std::uint32_t key_low;
  std::uint32_t id;

  static WideEntry make(const Steps& steps, std::uint32_t id) {
    const Key key = wide_morton_key(steps[0], steps[1], steps[2]);
    return {static_cast<std::uint64_t>(key >> 32), static_cast<std::uint32_t>(key), id};
  }
  Key key() const { return Key{key_high} << 32 | key_low; }
};
static_assert(sizeof(WideEntry) == 16);

template <class Entry>
Steps steps_of(const Entry& entry) {
  const typename Entry::Key key = entry.key();
  return {morton_coordinate(key, 0), morton_coordinate(key, 1), morton_coordinate(key, 2)};
}

/// The extent of a cloud's positions.
struct KeySpace {
  LatticePosition base{0};  ///< lowest lattice position on each axis
  int extent_bits = 0;      ///< bits that hold the largest step count from base; 0 .. 32

  /// Whether NarrowEntry holds the positions.
  bool is_narrow() const { return extent_bits <= k_morton_bits; }
};

/// The smallest space of these positions. Cost: one pass, in parallel.
KeySpace key_space(std::span<const LatticePosition> positions);

/// A space of these positions in which their order is that in the space of all lattice positions, and so in
/// all results of this function: pieces of a cloud that are sorted separately can be merged. Cost: one pass,
/// in parallel.
KeySpace aligned_key_space(const std::vector<LatticePosition>& positions);

/// Points in (Morton key, id) order.
template <class Entry>
class SortedPoints {
 public:
  explicit SortedPoints(std::size_t size, const ScratchFolder& scratch = {})
      : entries_(size, scratch),
        release_(entries_.data(), size * sizeof(Entry), k_release_block, scratch.has_value()) {}

  std::size_t size() const { return entries_.size(); }
  Entry* data() { return entries_.data(); }
  const Entry& operator[](std::size_t i) const { return entries_[i]; }

  /// Declares that these entries will not be read again: their memory is released when those around them are
  /// used up, too. Call at most once per entry; from any thread.
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
/// points, for any distribution. Memory at the peak: two entries per point beside the positions.
template <class Entry>
SortedPoints<Entry> sort_points(const KeySpace& space, const std::vector<LatticePosition>& positions);

/// sort_points() that uses up the positions, which are empty afterwards. Memory at the peak, including the
/// positions: one narrow or two wide entries per point.
template <class Entry>
SortedPoints<Entry> sort_points(const KeySpace& space, std::vector<LatticePosition>&& positions);

/// sort_points() for positions of a scratch file that is mapped into memory, which are used up; all large
/// data are in scratch files. Memory at the peak: that of `scratch`, or 12 MB per thread if that is more, and
/// 1/8 B per point.
template <class Entry>
SortedPoints<Entry> sort_points(const KeySpace& space, std::span<LatticePosition> positions,
                                const ScratchSpace& scratch);

}  // namespace alidade
