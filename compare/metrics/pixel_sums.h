// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

// Ranks among many floats without sorting or keeping them. Floats that are not negative are in the order of
// their bits; so two passes suffice, one over the upper, one over the lower 16 bits. All sums are of whole
// numbers: the same on any number of threads.
//
// Values come from a function value_at(i), i in [0, count), called from several threads; those with the sign
// bit set (-1.0f) are left out. None may be NaN.

namespace alidade {

/// How often each half of a float's bits occurs.
struct FloatCounts {
  std::vector<std::uint64_t> counts = std::vector<std::uint64_t>(65536);
  /// Of the lower halves, for each upper half; unused when lower halves are counted.
  std::vector<std::uint64_t> lower_sums = std::vector<std::uint64_t>(65536);

  void add(const FloatCounts& other) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      counts[i] += other.counts[i];
      lower_sums[i] += other.lower_sums[i];
    }
  }
};

/// Calls count(counts, bits) for the bits of each value.
template <class ValueAt, class Count>
FloatCounts count_floats(std::size_t size, const ValueAt& value_at, const Count& count) {
  constexpr std::size_t k_values_per_task = std::size_t{1} << 20;
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, size, k_values_per_task), FloatCounts(),
      [&](const auto& range, FloatCounts counts) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          const auto bits = std::bit_cast<std::uint32_t>(value_at(i));
          if (bits >> 31 == 0) count(counts, bits);
        }
        return counts;
      },
      [](FloatCounts one, const FloatCounts& other) {
        one.add(other);
        return one;
      });
}

template <class ValueAt>
FloatCounts count_upper_halves(std::size_t size, const ValueAt& value_at) {
  return count_floats(size, value_at, [](FloatCounts& counts, std::uint32_t bits) {
    ++counts.counts[bits >> 16];
    counts.lower_sums[bits >> 16] += bits & 0xffffu;
  });
}

template <class ValueAt>
FloatCounts count_lower_halves(std::size_t size, const ValueAt& value_at, std::uint32_t upper) {
  return count_floats(size, value_at, [upper](FloatCounts& counts, std::uint32_t bits) {
    if (bits >> 16 == upper) ++counts.counts[bits & 0xffffu];
  });
}

/// The value with so many others before it in ascending order; there must be more values than that.
template <class ValueAt>
float value_of_rank(std::size_t size, const ValueAt& value_at, const FloatCounts& uppers,
                    std::uint64_t rank) {
  std::uint32_t upper = 0;
  while (rank >= uppers.counts[upper]) rank -= uppers.counts[upper++];
  const FloatCounts lowers = count_lower_halves(size, value_at, upper);
  std::uint32_t lower = 0;
  while (rank >= lowers.counts[lower]) rank -= lowers.counts[lower++];
  return std::bit_cast<float>(upper << 16 | lower);
}

/// Sum of all values whose upper half is `upper`.
inline double sum_of(const FloatCounts& uppers, std::uint32_t upper) {
  // Between floats of one upper half the steps are equal.
  const double begin = std::bit_cast<float>(upper << 16);
  const double step = static_cast<double>(std::bit_cast<float>(upper << 16 | 1u)) - begin;
  return static_cast<double>(uppers.counts[upper]) * begin +
         static_cast<double>(uppers.lower_sums[upper]) * step;
}

/// The first value in ascending order at which the running sum exceeds `share` of the sum of all; 0 if the
/// sum is 0.
template <class ValueAt>
float weighted_rank(std::size_t size, const ValueAt& value_at, const FloatCounts& uppers, double share) {
  double total = 0.0;
  constexpr std::uint32_t k_infinity = 0x7f80u;
  for (std::uint32_t upper = 0; upper < k_infinity; ++upper)
    if (uppers.counts[upper] > 0) total += sum_of(uppers, upper);
  if (!(total > 0.0)) return 0.0f;
  double running = 0.0;
  std::uint32_t upper = 0, last = 0;
  for (; upper < k_infinity; ++upper) {
    if (uppers.counts[upper] == 0) continue;
    last = upper;
    const double sum = sum_of(uppers, upper);
    if (running + sum > share * total) break;
    running += sum;
  }
  upper = last;
  const FloatCounts lowers = count_lower_halves(size, value_at, upper);
  float value = 0.0f;
  for (std::uint32_t lower = 0; lower < 65536; ++lower) {
    if (lowers.counts[lower] == 0) continue;
    value = std::bit_cast<float>(upper << 16 | lower);
    running += static_cast<double>(lowers.counts[lower]) * static_cast<double>(value);
    if (running > share * total) break;
  }
  return value;
}

}  // namespace alidade
