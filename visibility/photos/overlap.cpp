// SPDX-License-Identifier: MIT
#include "visibility/photos/overlap.h"

#include <bit>

#include "base/parallel.h"

namespace alidade::visibility {

std::uint64_t common_points(const SeenSet& a, const SeenSet& b) {
  std::uint64_t points = 0;
  auto other = b.blocks.begin();
  for (const auto& [number, bits] : a.blocks) {
    while (other != b.blocks.end() && other->first < number) ++other;
    if (other == b.blocks.end()) break;
    if (other->first != number) continue;
    for (std::size_t word = 0; word < bits.size(); ++word)
      points += static_cast<std::uint64_t>(std::popcount(bits[word] & other->second[word]));
  }
  return points;
}

std::vector<PhotoOverlap> overlaps(const std::vector<SeenSet>& photos) {
  std::vector<std::vector<PhotoOverlap>> rows(photos.size());
  in_parallel(photos.size(), 1, [&](std::size_t first) {
    for (std::size_t second = first + 1; second < photos.size(); ++second) {
      const std::uint64_t points = common_points(photos[first], photos[second]);
      if (points > 0)
        rows[first].push_back(
            {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(second), points});
    }
  });
  std::vector<PhotoOverlap> all;
  for (const std::vector<PhotoOverlap>& row : rows) all.insert(all.end(), row.begin(), row.end());
  return all;
}

}  // namespace alidade::visibility
