// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

namespace alidade {

/// Key ranges of about equal numbers of points, for sorting range by range. A key of which the cloud has very
/// many points gets a range of its own.
template <class Key>
class KeyBuckets {
 public:
  /// Buckets numbers fit 16 bits with room.
  static constexpr std::size_t k_max_count = 4096;
  static constexpr std::size_t k_samples_per_bucket = 16;

  /// `samples`: keys of points taken evenly, k_samples_per_bucket for every bucket that is wanted.
  explicit KeyBuckets(std::vector<Key> samples) {
    std::ranges::sort(samples);
    std::vector<Key> limits;
    for (std::size_t i = k_samples_per_bucket; i < samples.size(); i += k_samples_per_bucket) {
      if (limits.empty() || samples[i] > limits.back()) {
        limits.push_back(samples[i]);
      } else if (samples[i] == limits.back()) {
        limits.push_back(samples[i] + 1);  // ends the bucket of this very key
      }
    }
    count_ = limits.size() + 1;
    limits.resize(std::bit_ceil(count_), ~Key{0});
    limits_ = std::move(limits);
  }

  std::size_t count() const { return count_; }

  /// The buckets of several keys at once, so that the processor searches them side by side.
  template <std::size_t width>
  void find(const std::array<Key, width>& keys, std::uint16_t* buckets) const {
    std::array<std::size_t, width> low{};
    for (std::size_t step = limits_.size() / 2; step > 0; step /= 2) {
      for (std::size_t i = 0; i < width; ++i) low[i] += limits_[low[i] + step - 1] <= keys[i] ? step : 0;
    }
    for (std::size_t i = 0; i < width; ++i) buckets[i] = static_cast<std::uint16_t>(low[i]);
  }

 private:
  std::size_t count_ = 1;
  std::vector<Key> limits_;  ///< lower ends of all buckets but the first, then keys above all; 2^n of them
};

/// Sorts entries by key from `from` into `to`; equal keys keep their order. Uses up `from`. Radix sort from
/// the highest bit in which keys differ, with insertion sort for the small groups that leaves.
/// `k_max_digit_bits`: of the first pass; later ones take less, to stay small on the stack.
template <class Entry, int k_max_digit_bits = 12>
void sort_by_key(Entry* from, Entry* to, std::size_t count) {
  using Key = typename Entry::Key;
  constexpr std::size_t k_small = 24;
  if (count <= k_small) {
    for (std::size_t i = 0; i < count; ++i) {
      const Entry entry = from[i];
      const Key key = entry.key();
      std::size_t at = i;
      for (; at > 0 && key < to[at - 1].key(); --at) to[at] = to[at - 1];
      to[at] = entry;
    }
    return;
  }
  const Key first = from[0].key();
  Key difference = 0;
  for (std::size_t i = 1; i < count; ++i) difference |= from[i].key() ^ first;
  if (difference == 0) {
    std::memcpy(to, from, count * sizeof(Entry));
    return;
  }
  // Groups of about four entries where keys are evenly spread.
  const int digit_bits = std::clamp(static_cast<int>(std::bit_width(count)) - 3, 1, k_max_digit_bits);
  const int shift = std::max(0, highest_bit(difference) + 1 - digit_bits);
  const auto digit_of = [&](const Entry& entry) {
    return static_cast<std::uint32_t>(entry.key() >> shift) & ((1u << digit_bits) - 1u);
  };
  std::array<std::uint32_t, std::size_t{1} << k_max_digit_bits> end;
  const std::size_t digit_count = std::size_t{1} << digit_bits;
  std::fill_n(end.begin(), digit_count, 0u);
  for (std::size_t i = 0; i < count; ++i) ++end[digit_of(from[i])];
  std::uint32_t begin = 0;
  for (std::size_t digit = 0; digit < digit_count; ++digit) begin += std::exchange(end[digit], begin);
  for (std::size_t i = 0; i < count; ++i) to[end[digit_of(from[i])]++] = from[i];
  if (shift == 0) return;
  begin = 0;
  for (std::size_t digit = 0; digit < digit_count; ++digit) {
    const std::uint32_t group = end[digit] - begin;
    if (group > 1) {
      std::memcpy(from + begin, to + begin, group * sizeof(Entry));
      sort_by_key<Entry, 8>(from + begin, to + begin, group);
    }
    begin = end[digit];
  }
}

}  // namespace alidade
