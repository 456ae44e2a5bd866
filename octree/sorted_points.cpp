// SPDX-License-Identifier: MIT
#include "octree/sorted_points.h"

#include <sys/mman.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

namespace alidade {
namespace {

constexpr int k_digit_bits = 12;
constexpr std::size_t k_bucket_count = std::size_t{1} << k_digit_bits;
constexpr std::size_t k_points_per_task = std::size_t{1} << 16;
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

std::uint32_t steps_from(std::int32_t base, std::int32_t value) {
  return static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(base);
}

SortEntry entry(const LatticePosition& packed) {
  return std::bit_cast<SortEntry>(packed);
}

bool less(const LatticePosition& a, const LatticePosition& b) {
  const SortEntry entry_a = entry(a), entry_b = entry(b);
  const std::uint64_t key_a = entry_a.key(), key_b = entry_b.key();
  return key_a != key_b ? key_a < key_b : entry_a.id < entry_b.id;
}

using Places = std::array<std::size_t, k_bucket_count + 1>;

Places count_buckets(const std::vector<LatticePosition>& packed, int digit_shift) {
  Places begin{};
  for (const LatticePosition& p : packed) ++begin[(entry(p).key() >> digit_shift) + 1];
  for (std::size_t bucket = 0; bucket < k_bucket_count; ++bucket) begin[bucket + 1] += begin[bucket];
  return begin;
}

/// Brings every entry into the bucket of its leading digit without a second buffer: what stands in the way is
/// carried on to its own bucket until the circle closes. Source: McIlroy, Bostic, McIlroy, Engineering Radix
/// Sort, 1993.
void permute_into_buckets(std::vector<LatticePosition>& packed, const Places& begin, int digit_shift) {
  Places next = begin;
  for (std::size_t bucket = 0; bucket < k_bucket_count; ++bucket) {
    while (next[bucket] < begin[bucket + 1]) {
      LatticePosition carried = packed[next[bucket]];
      for (std::size_t target; (target = entry(carried).key() >> digit_shift) != bucket;) {
        std::swap(carried, packed[next[target]++]);
      }
      packed[next[bucket]++] = carried;
    }
  }
}

}  // namespace

KeySpace key_space(const std::vector<LatticePosition>& positions) {
  if (positions.empty()) return {};
  const Extent extent = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, positions.size(), k_points_per_task), Extent{},
      [&](const tbb::blocked_range<std::size_t>& range, Extent part) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) part.grow(positions[i]);
        return part;
      },
      [](Extent a, const Extent& b) {
        a.grow(b.low);
        a.grow(b.high);
        return a;
      });
  std::uint32_t largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max(largest, steps_from(extent.low[axis], extent.high[axis]));
  const int extent_bits = std::bit_width(largest);
  return {extent.low, extent_bits, std::max(0, extent_bits - k_morton_bits)};
}

SortedPoints sort_points(const KeySpace& space, std::vector<LatticePosition> positions) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, positions.size(), k_points_per_task), [&](const auto& range) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          std::array<std::uint32_t, 3> steps;
          for (int axis = 0; axis < 3; ++axis)
            steps[axis] = steps_from(space.base[axis], positions[i][axis]) >> space.key_shift;
          const std::uint64_t key = morton_key(steps[0], steps[1], steps[2]);
          positions[i] = std::bit_cast<LatticePosition>(SortEntry{static_cast<std::uint32_t>(key),
                                                                  static_cast<std::uint32_t>(key >> 32),
                                                                  static_cast<std::uint32_t>(i)});
        }
      });

  const int digit_shift = std::max(0, 3 * (space.extent_bits - space.key_shift) - k_digit_bits);
  const Places begin = count_buckets(positions, digit_shift);
  permute_into_buckets(positions, begin, digit_shift);
  tbb::parallel_for(std::size_t{0}, k_bucket_count, [&](std::size_t bucket) {
    const auto first = positions.begin() + static_cast<std::ptrdiff_t>(begin[bucket]);
    const auto last = positions.begin() + static_cast<std::ptrdiff_t>(begin[bucket + 1]);
    if (static_cast<std::size_t>(last - first) > k_parallel_bucket) {
      tbb::parallel_sort(first, last, less);
    } else {
      std::sort(first, last, less);
    }
  });
  return {space, std::move(positions)};
}

void SortedPoints::discard(std::size_t begin, std::size_t end) {
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto first = (reinterpret_cast<std::uintptr_t>(packed_.data() + begin) + page - 1) / page * page;
  const auto last = reinterpret_cast<std::uintptr_t>(packed_.data() + end) / page * page;
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
}

}  // namespace alidade
