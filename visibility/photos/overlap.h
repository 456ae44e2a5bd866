// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace alidade::visibility {

/// Points in one block of a SeenSet.
constexpr std::size_t k_seen_block = 4096;
using SeenBlock = std::array<std::uint64_t, k_seen_block / 64>;

/// The points that a photo sees, as bits in blocks; blocks without any are left out. If neighbours in space
/// have neighbouring numbers, a photo takes some bits per point that it sees.
struct SeenSet {
  std::vector<std::pair<std::uint32_t, SeenBlock>> blocks;  ///< by number, ascending

  std::uint64_t byte_count() const { return blocks.size() * sizeof(blocks[0]); }
};

/// Number of points that both of two photos see.
std::uint64_t common_points(const SeenSet& a, const SeenSet& b);

/// Two photos with points that both see.
struct PhotoOverlap {
  std::uint32_t first = 0, second = 0;  ///< indices of the photos, first < second
  std::uint64_t points = 0;             ///< seen by both, > 0
};

/// All pairs with points in common, by `first`, then `second`. The same on any number of threads. Cost: for
/// each pair linear in the blocks of both, 10^8 shared points per second and thread or more.
std::vector<PhotoOverlap> overlaps(const std::vector<SeenSet>& photos);

}  // namespace alidade::visibility
