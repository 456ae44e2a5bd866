// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "base/parallel.h"
#include "compare/compared_image.h"
#include "image/srgb.h"

namespace alidade::compare {

/// The curve that brings the colours of an image into an encoding; null: they have it.
inline const image::CurveTable* curve_of(const ComparedImage& image, ColorEncoding encoding) {
  if (image.encoding == encoding) return nullptr;
  return encoding == ColorEncoding::linear ? &image::linear_from_srgb_table()
                                           : &image::srgb_from_linear_table();
}

/// The colours of two images as filters read them. Where a pixel does not count, or is not finite in one of
/// them, both have one colour (the reference's if it is finite, else the test's, else black), so that
/// excluded pixels do not affect their neighbours either.
class PairPixels {
 public:
  /// The images must be of equal size, have colour, and outlive this; so must the mask.
  PairPixels(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask,
             ColorEncoding encoding)
      : mask_(mask),
        colors_{reference.color.data(), test.color.data()},
        curves_{curve_of(reference, encoding), curve_of(test, encoding)} {}

  struct Pair {
    float color[2][3];  ///< reference, test
  };

  Pair at(std::size_t pixel) const {
    const float* from[2] = {colors_[0] + 3 * pixel, colors_[1] + 3 * pixel};
    const bool finite[2] = {is_finite(from[0]), is_finite(from[1])};
    if (!mask_.at(pixel) || !finite[0] || !finite[1]) {
      if (!finite[0] && !finite[1]) return {};
      Pair same;
      const int kept = finite[0] ? 0 : 1;
      for (int i = 0; i < 3; ++i) same.color[0][i] = same.color[1][i] = converted(kept, from[kept][i]);
      return same;
    }
    Pair pair;
    for (int image = 0; image < 2; ++image)
      for (int i = 0; i < 3; ++i) pair.color[image][i] = converted(image, from[image][i]);
    return pair;
  }

 private:
  float converted(int image, float value) const { return curves_[image] ? curves_[image]->at(value) : value; }

  const ImageMask& mask_;
  const float* colors_[2];
  const image::CurveTable* curves_[2];
};

// Ranks among many floats without sorting or keeping them. Floats that are not negative are in the order of
// their bits; so two passes suffice, one over the upper, one over the lower 16 bits. All sums are of whole
// numbers: equal on any number of threads.
//
// Values come from a function value_at(i), i in [0, count), called from several threads; those with the sign
// bit set (-1.0f) are left out. None may be NaN.

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
  FloatCounts all;
  std::mutex mutex;  // of these
  in_blocks(size, k_values_per_task, [&](std::size_t first, std::size_t end) {
    FloatCounts counts;
    for (std::size_t i = first; i != end; ++i) {
      const auto bits = std::bit_cast<std::uint32_t>(value_at(i));
      if (bits >> 31 == 0) count(counts, bits);
    }
    const std::lock_guard lock(mutex);
    all.add(counts);
  });
  return all;
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

// Sums over the rows of an image, equal on any number of threads.

/// Runs row(y, its sums) for all rows, in parallel, and adds the sums up from the top.
template <class Sums, class Row>
Sums sum_rows(std::size_t height, const Row& row) {
  std::vector<Sums> rows(height);
  in_parallel(height, 16, [&](std::size_t y) { row(y, rows[y]); });
  Sums all;
  for (const Sums& one : rows) all.add(one);
  return all;
}

/// Differences in one number: whole ones are added as such, others as double.
template <class Number>
struct DifferenceSums {
  std::uint64_t values = 0;
  Number sum = 0, sum_abs = 0, sum_squares = 0;
  Number most = 0;          ///< the largest size
  std::size_t most_at = 0;  ///< its index, the first in reading order

  void add(Number difference, std::size_t index) {
    const Number size = difference < 0 ? -difference : difference;
    ++values;
    sum += difference;
    sum_abs += size;
    sum_squares += difference * difference;
    if (size > most) {
      most = size;
      most_at = index;
    }
  }

  /// Adds the sums of pixels that come later in reading order.
  void add(const DifferenceSums& later) {
    values += later.values;
    sum += later.sum;
    sum_abs += later.sum_abs;
    sum_squares += later.sum_squares;
    if (later.most > most) {
      most = later.most;
      most_at = later.most_at;
    }
  }

  /// A sum by the number of values; 0 without any.
  double mean(Number of_all) const {
    return values == 0 ? 0.0 : static_cast<double>(of_all) / static_cast<double>(values);
  }
};

/// The smallest of the values that are not negative which at least 95 % of them do not exceed; 0 without any.
/// `values` is how many there are; value_at(i) as for count_upper_halves().
template <class ValueAt>
double percentile_95(std::size_t size, const ValueAt& value_at, std::uint64_t values) {
  if (values == 0) return 0.0;
  // The smallest whole number that is not below 95 % of the values, counted from 0.
  const std::uint64_t rank = values - values / 20 - 1;
  return static_cast<double>(value_of_rank(size, value_at, count_upper_halves(size, value_at), rank));
}

}  // namespace alidade::compare
