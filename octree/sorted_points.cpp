// SPDX-License-Identifier: MIT
#include "octree/sorted_points.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <utility>

namespace alidade {
namespace {

constexpr int k_first_digit_bits = 12;
constexpr std::size_t k_bucket_count = std::size_t{1} << k_first_digit_bits;
constexpr std::size_t k_points_per_block = std::size_t{1} << 18;
constexpr std::size_t k_max_block_count = 256;
// A bucket beyond this size would leave the other threads idle if one sorted it alone.
constexpr std::size_t k_parallel_bucket = std::size_t{1} << 19;

struct Extent {
  LatticePosition low{2147483647}, high{-2147483647 - 1};

  void grow(const LatticePosition& p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
};

Extent measure_extent(const std::vector<LatticePosition>& positions) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, positions.size(), k_points_per_block), Extent{},
      [&](const tbb::blocked_range<std::size_t>& range, Extent extent) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) extent.grow(positions[i]);
        return extent;
      },
      [](Extent a, const Extent& b) {
        a.grow(b.low);
        a.grow(b.high);
        return a;
      });
}

std::uint32_t steps_from(std::int32_t base, std::int32_t value) {
  return static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(base);
}

bool less(const SortEntry& a, const SortEntry& b) {
  const std::uint64_t key_a = a.key(), key_b = b.key();
  return key_a != key_b ? key_a < key_b : a.id < b.id;
}

}  // namespace

SortedPoints sort_points(const std::vector<LatticePosition>& positions,
                         std::vector<LatticePosition>* released) {
  SortedPoints sorted;
  sorted.count = positions.size();
  if (positions.empty()) return sorted;

  const Extent extent = measure_extent(positions);
  sorted.base = extent.low;
  std::uint32_t largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max(largest, steps_from(extent.low[axis], extent.high[axis]));
  sorted.extent_bits = std::bit_width(largest);
  sorted.key_shift = std::max(0, sorted.extent_bits - k_morton_bits);

  const int key_bits = 3 * (sorted.extent_bits - sorted.key_shift);
  const int digit_shift = std::max(0, key_bits - k_first_digit_bits);
  const auto key_of = [&](const LatticePosition& p) {
    return morton_key(steps_from(sorted.base.x, p.x) >> sorted.key_shift,
                      steps_from(sorted.base.y, p.y) >> sorted.key_shift,
                      steps_from(sorted.base.z, p.z) >> sorted.key_shift);
  };

  // Counting sort on the leading digit straight out of the positions, so that only one buffer of entries is
  // needed.
  const std::size_t count = positions.size();
  const std::size_t block_size =
      std::max(k_points_per_block, (count + k_max_block_count - 1) / k_max_block_count);
  const std::size_t block_count = (count + block_size - 1) / block_size;
  std::vector<std::uint32_t> places(block_count * k_bucket_count, 0);
  const auto for_block = [&](std::size_t block, auto&& visit) {
    const std::size_t end = std::min(count, (block + 1) * block_size);
    for (std::size_t i = block * block_size; i < end; ++i) visit(i);
  };
  tbb::parallel_for(std::size_t{0}, block_count, [&](std::size_t block) {
    std::uint32_t* counts = &places[block * k_bucket_count];
    for_block(block, [&](std::size_t i) { ++counts[key_of(positions[i]) >> digit_shift]; });
  });
  std::vector<std::size_t> bucket_begin(k_bucket_count + 1);
  std::uint32_t place = 0;
  for (std::size_t bucket = 0; bucket < k_bucket_count; ++bucket) {
    bucket_begin[bucket] = place;
    for (std::size_t block = 0; block < block_count; ++block) {
      place += std::exchange(places[block * k_bucket_count + bucket], place);
    }
  }
  bucket_begin[k_bucket_count] = place;

  sorted.entries = std::make_unique_for_overwrite<SortEntry[]>(count);
  tbb::parallel_for(std::size_t{0}, block_count, [&](std::size_t block) {
    std::uint32_t* next = &places[block * k_bucket_count];
    for_block(block, [&](std::size_t i) {
      const std::uint64_t key = key_of(positions[i]);
      sorted.entries[next[key >> digit_shift]++] = {static_cast<std::uint32_t>(key),
                                                    static_cast<std::uint32_t>(key >> 32),
                                                    static_cast<std::uint32_t>(i)};
    });
  });
  if (released && sorted.key_shift == 0) std::vector<LatticePosition>().swap(*released);

  tbb::parallel_for(std::size_t{0}, k_bucket_count, [&](std::size_t bucket) {
    SortEntry* begin = sorted.entries.get() + bucket_begin[bucket];
    SortEntry* end = sorted.entries.get() + bucket_begin[bucket + 1];
    if (static_cast<std::size_t>(end - begin) > k_parallel_bucket) {
      tbb::parallel_sort(begin, end, less);
    } else {
      std::sort(begin, end, less);
    }
  });
  return sorted;
}

}  // namespace alidade
