// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "octree/simd/first_answers.h"

// Sorting in linear time.

namespace alidade::simd {

/// What orders in the upper half, the number of what is ordered in the lower one.
using SortKey = std::uint64_t;

constexpr std::uint32_t number_of(SortKey key) {
  return static_cast<std::uint32_t>(key);
}

/// Fewer are sorted faster by comparing them.
constexpr std::size_t k_few_keys = 64;

/// Sorts by the upper halves, digit by digit, the lowest first. Requires: fewer than 2^32 keys; lower halves
/// that ascend where upper ones are equal, if the order of these matters.
inline void sort_keys(std::vector<SortKey>& keys) {
  if (keys.size() <= k_few_keys) return std::sort(keys.begin(), keys.end());
  SortKey all = 0, previous = 0;
  bool is_sorted = true;
  for (const SortKey key : keys) {
    all |= key;
    is_sorted = is_sorted && key >= previous;
    previous = key;
  }
  if (is_sorted) return;
  constexpr int k_most_digit_bits = 11;
  const int bits = std::max(static_cast<int>(std::bit_width(all)) - 32, 1);
  const int digits = (bits + k_most_digit_bits - 1) / k_most_digit_bits;
  const int digit_bits = (bits + digits - 1) / digits;
  const SortKey mask = (SortKey{1} << digit_bits) - 1;
  std::vector<SortKey> sorted(keys.size());
  for (int shift = 32; shift < 32 + bits; shift += digit_bits) {
    std::array<std::uint32_t, std::size_t{1} << k_most_digit_bits> next;  ///< number of a digit's next key
    std::fill_n(next.begin(), mask + 1, 0u);
    for (const SortKey key : keys) ++next[key >> shift & mask];
    std::exclusive_scan(next.begin(), next.begin() + static_cast<std::ptrdiff_t>(mask + 1), next.begin(), 0u);
    for (const SortKey key : keys) sorted[next[key >> shift & mask]++] = key;
    keys.swap(sorted);
  }
}

/// Puts answers in the order of their target, from number `first` on. Cost: linear unless most measures are
/// nearly equal.
template <class Target>
void sort_answers(const Target& target, std::size_t first, std::vector<typename Target::Answer>& answers) {
  using Answer = typename Target::Answer;
  const std::size_t count = answers.size() - first;
  Answer* const unsorted = answers.data() + first;
  const auto by_comparing = [&] { std::sort(unsorted, unsorted + count, Precedes<Target>{target}); };
  if (count <= k_few_keys) return by_comparing();
  double low = target.measured(unsorted[0]), high = low;
  for (std::size_t i = 1; i < count; ++i) {
    low = std::min(low, target.measured(unsorted[i]));
    high = std::max(high, target.measured(unsorted[i]));
  }
  // Measures become steps of their range, some for each answer; steps never fall when measures grow.
  constexpr double k_largest = std::numeric_limits<double>::max();
  const int bits = std::min(static_cast<int>(std::bit_width(count)) + 4, 32);
  const double steps = static_cast<double>((SortKey{1} << bits) - 1) / (high - low);
  if (!(high - low <= k_largest && steps <= k_largest)) return by_comparing();
  std::vector<SortKey> keys(count);
  for (std::size_t i = 0; i < count; ++i)
    keys[i] = static_cast<SortKey>((target.measured(unsorted[i]) - low) * steps) << 32 | i;
  sort_keys(keys);
  const auto precedes = [&](SortKey a, SortKey b) {
    return target.precedes(unsorted[number_of(a)], unsorted[number_of(b)]);
  };
  for (auto begin = keys.begin(); begin != keys.end();) {
    auto end = begin + 1;
    while (end != keys.end() && *end >> 32 == *begin >> 32) ++end;
    if (end - begin > 1) std::sort(begin, end, precedes);
    begin = end;
  }
  std::vector<Answer> sorted;
  sorted.reserve(count);
  for (const SortKey key : keys) sorted.push_back(unsorted[number_of(key)]);
  if (first == 0) {
    answers.swap(sorted);
  } else {
    std::copy(sorted.begin(), sorted.end(), unsorted);
  }
}

}  // namespace alidade::simd
