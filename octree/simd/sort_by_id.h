// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace alidade::simd {

/// Point id in the upper half, anything in the lower one.
using IdKey = std::uint64_t;

/// Brings keys into the order of their ids, which differ, and keeps the k lowest. Cost: linear.
inline void sort_by_id(std::vector<IdKey>& keys, std::size_t k) {
  if (keys.size() > k) {
    std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(k), keys.end());
    keys.resize(k);
  }
  constexpr std::size_t k_few = 64;
  if (keys.size() <= k_few || keys.size() > 0xffffffffu) return std::sort(keys.begin(), keys.end());
  if (std::is_sorted(keys.begin(), keys.end())) return;

  // Digit by digit, the lowest first.
  constexpr int k_digit_bits = 11;
  std::vector<IdKey> sorted(keys.size());
  std::uint64_t all = 0;
  for (const IdKey key : keys) all |= key;
  for (int shift = 32; shift < static_cast<int>(std::bit_width(all)); shift += k_digit_bits) {
    const auto digit = [&](IdKey key) { return key >> shift & ((1u << k_digit_bits) - 1u); };
    std::array<std::uint32_t, std::size_t{1} << k_digit_bits> place{};
    for (const IdKey key : keys) ++place[digit(key)];
    std::uint32_t next = 0;
    for (std::uint32_t& count_or_place : place) {
      const std::uint32_t here = count_or_place;
      count_or_place = next;
      next += here;
    }
    for (const IdKey key : keys) sorted[place[digit(key)]++] = key;
    keys.swap(sorted);
  }
}

}  // namespace alidade::simd
