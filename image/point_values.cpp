// SPDX-License-Identifier: MIT
#include "image/point_values.h"

#include <tbb/enumerable_thread_specific.h>
#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "cloud/point_table.h"

namespace alidade::image {
namespace {

constexpr std::size_t k_block_rows = 2048;
constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

double value_or_nan(double value) {
  return std::fabs(value) <= k_largest_value ? value : k_nan;
}

/// The values value_at(row), which are computed at each visit.
template <class ValueAt>
PointValues of_rows(std::uint64_t count, const ValueAt& value_at) {
  return {.count = count, .for_each_block = [count, value_at](const VisitBlock& visit) {
            in_blocks(count, k_block_rows, [&](std::size_t begin, std::size_t end) {
              std::array<double, k_block_rows> values;
              for (std::size_t i = begin; i < end; ++i) values[i - begin] = value_or_nan(value_at(i));
              visit({.values = {values.data(), end - begin}, .first_id = begin, .ids = {}});
            });
          }};
}

template <class Value>
PointValues of_column(std::span<const Value> column) {
  return of_rows(column.size(), [column](std::uint64_t row) { return static_cast<double>(column[row]); });
}

double return_or_nan(std::uint8_t number) {
  return number == 0 ? k_nan : number;
}

PointValues of_extra(const ExtraColumn& column) {
  const auto width = static_cast<std::size_t>(column.description.byte_count);
  return of_rows(column.values.size() / width,
                 [width, &dimension = column.description, values = column.values.data()](std::uint64_t row) {
                   return meant_number(dimension, values + row * width);
                 });
}

PointValues of_attribute(const std::string& name, const AttributeColumns& columns) {
  if (name == "near_infrared") return of_column(columns.near_infrared);
  if (name == "flags") return of_column(columns.flags);
  if (name == "scan_angle") return of_column(columns.scan_angles);
  if (name == "user_data") return of_column(columns.user_data);
  if (name == "point_source_id") return of_column(columns.point_source_ids);
  const ExtraColumn* const extra = find_numbers(columns, name);
  assert(extra != nullptr);
  return of_extra(*extra);
}

constexpr int k_digit_bits = 16;
constexpr std::size_t k_digits = std::size_t{1} << k_digit_bits;  ///< values of a digit
constexpr std::uint64_t k_sign = std::uint64_t{1} << 63;

/// Maps doubles to integers in the same order.
std::uint64_t ordered_bits(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value + 0.0);  // no negative zero
  return (bits & k_sign) != 0 ? ~bits : bits | k_sign;
}

double from_ordered_bits(std::uint64_t ordered) {
  return std::bit_cast<double>((ordered & k_sign) != 0 ? ordered ^ k_sign : ~ordered);
}

/// The search for the value of one rank, digit by digit.
struct Search {
  std::uint64_t rank = 0;    ///< among the values that begin with the prefix, from 0
  std::uint64_t prefix = 0;  ///< the leading digits found so far
};

using Histogram = std::vector<std::uint64_t>;
using Histograms = std::array<Histogram, 2>;

/// For each search, how often each digit follows its prefix.
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

bool has_numbers(const ExtraColumn& column) {
  return scalar_size(column.description.type) > 0;
}

const ExtraColumn* find_numbers(const AttributeColumns& columns, std::string_view name) {
  const auto found = std::ranges::find_if(columns.extra_dimensions, [&](const ExtraColumn& column) {
    return column.description.name == name && has_numbers(column);
  });
  return found == columns.extra_dimensions.end() ? nullptr : &*found;
}

PointValues values_of(const PointColoring& coloring, const AttributeColumns& columns,
                      const PointValues& heights) {
  const std::span<const ReturnNumbers> returns = columns.returns;
  switch (coloring.by) {
    case PointColor::intensity:
      return of_column(columns.intensities);
    case PointColor::classification:
      return of_column(columns.classifications);
    case PointColor::gps_time:
      return of_column(columns.gps_times);
    case PointColor::return_number:
      return of_rows(returns.size(), [=](std::uint64_t row) { return return_or_nan(returns[row].number); });
    case PointColor::number_of_returns:
      return of_rows(returns.size(), [=](std::uint64_t row) { return return_or_nan(returns[row].count); });
    case PointColor::attribute:
      return of_attribute(coloring.attribute, columns);
    default:
      assert(coloring.by == PointColor::height);
      return heights;
  }
}

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
  // Turns -0.0 into 0.0: which of the two is met first depends on the threads.
  return {{all.range.low + 0.0, all.range.high + 0.0}, all.count};
}

ValueRange percentiles_of(const PointValues& values, const ValueExtent& extent,
                          const ValueRange& percentiles) {
  if (extent.count == 0) return {};
  const bool is_all = percentiles.low == 0.0 && percentiles.high == 100.0;
  if (is_all || extent.range.low == extent.range.high) return extent.range;
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

double position_in(const ValueRange& range, double value) {
  if (std::isnan(value)) return value;
  if (!(range.high > range.low)) return 0.5;
  return std::clamp((value - range.low) / (range.high - range.low), 0.0, 1.0);
}

}  // namespace alidade::image
