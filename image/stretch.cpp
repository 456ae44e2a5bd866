// SPDX-License-Identifier: MIT
#include "image/stretch.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

namespace alidade {
namespace {

constexpr int k_digit_bits = 16;
constexpr std::size_t k_digits = std::size_t{1} << k_digit_bits;
constexpr std::uint64_t k_sign = std::uint64_t{1} << 63;

/// Whole numbers in the order of the doubles they stand for.
std::uint64_t ordered_bits(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value + 0.0);  // no negative zero
  return (bits & k_sign) != 0 ? ~bits : bits | k_sign;
}

double from_ordered_bits(std::uint64_t ordered) {
  return std::bit_cast<double>((ordered & k_sign) != 0 ? ordered ^ k_sign : ~ordered);
}

/// The search for the value of one rank: its leading digits are known.
struct Search {
  std::uint64_t rank = 0;    ///< among the values that begin with these digits
  std::uint64_t prefix = 0;  ///< the digits found
};

using Histogram = std::vector<std::uint64_t>;
using Histograms = std::array<Histogram, 2>;

/// Counts the next digits of the values that begin with what either search has found.
Histograms count_digits(const PointValues& values, const std::array<Search, 2>& searches, int shift) {
  const Histograms zeros = {Histogram(k_digits), Histogram(k_digits)};
  tbb::enumerable_thread_specific<Histograms> of_threads(zeros);
  values.for_each_block([&](const ValueBlock& block) {
    Histograms& counts = of_threads.local();
    for (const double value : block.values) {
      if (std::isnan(value)) continue;
      const std::uint64_t ordered = ordered_bits(value);
      const std::uint64_t prefix =
          shift + k_digit_bits < 64 ? ordered >> (shift + k_digit_bits) : std::uint64_t{0};
      const std::size_t digit = ordered >> shift & (k_digits - 1);
      for (std::size_t i = 0; i < searches.size(); ++i) counts[i][digit] += prefix == searches[i].prefix;
    }
  });
  Histograms sums = zeros;
  for (const Histograms& counts : of_threads) {
    for (std::size_t i = 0; i < sums.size(); ++i) {
      for (std::size_t digit = 0; digit < k_digits; ++digit) sums[i][digit] += counts[i][digit];
    }
  }
  return sums;
}

}  // namespace

ValueExtent extent_of(const PointValues& values) {
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  const ValueExtent nothing{.range = {k_infinity, -k_infinity}, .count = 0};
  tbb::enumerable_thread_specific<ValueExtent> of_threads(nothing);
  values.for_each_block([&](const ValueBlock& block) {
    ValueExtent& extent = of_threads.local();
    for (const double value : block.values) {
      if (std::isnan(value)) continue;
      extent.range.low = std::min(extent.range.low, value);
      extent.range.high = std::max(extent.range.high, value);
      ++extent.count;
    }
  });
  ValueExtent all = nothing;
  for (const ValueExtent& extent : of_threads) {
    all.range.low = std::min(all.range.low, extent.range.low);
    all.range.high = std::max(all.range.high, extent.range.high);
    all.count += extent.count;
  }
  if (all.count == 0) return {};
  // No negative zero, which some threads may have met and others not.
  return {{all.range.low + 0.0, all.range.high + 0.0}, all.count};
}

ValueRange percentiles_of(const PointValues& values, const ValueExtent& extent,
                          const ValueRange& percentiles) {
  if (extent.count == 0) return {};
  const bool whole = percentiles.low == 0.0 && percentiles.high == 100.0;
  if (whole || extent.range.low == extent.range.high) return extent.range;
  const auto last = static_cast<double>(extent.count - 1);
  std::array<Search, 2> searches = {
      {{.rank = static_cast<std::uint64_t>(std::floor(percentiles.low * last / 100.0))},
       {.rank = static_cast<std::uint64_t>(std::ceil(percentiles.high * last / 100.0))}}};
  for (int shift = 64 - k_digit_bits; shift >= 0; shift -= k_digit_bits) {
    const Histograms counts = count_digits(values, searches, shift);
    for (std::size_t i = 0; i < searches.size(); ++i) {
      Search& search = searches[i];
      std::uint64_t digit = 0;
      for (; search.rank >= counts[i][digit]; ++digit) search.rank -= counts[i][digit];
      search.prefix = search.prefix << k_digit_bits | digit;
    }
  }
  return {from_ordered_bits(searches[0].prefix), from_ordered_bits(searches[1].prefix)};
}

double place_in(const ValueRange& range, double value) {
  if (std::isnan(value)) return value;
  if (!(range.high > range.low)) return 0.5;
  return std::clamp((value - range.low) / (range.high - range.low), 0.0, 1.0);
}

}  // namespace alidade
