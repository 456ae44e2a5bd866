// SPDX-License-Identifier: MIT
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "compare/metrics/pixel_sums.h"

// Sums over the rows of a picture, the same on any number of threads.

namespace alidade {

/// Runs row(y, its sums) for all rows, in parallel, and adds the sums up from the top.
template <class Sums, class Row>
Sums sum_rows(std::size_t height, const Row& row) {
  std::vector<Sums> rows(height);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, height, 16), [&](const auto& range) {
    for (std::size_t y = range.begin(); y != range.end(); ++y) row(y, rows[y]);
  });
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
  std::size_t most_at = 0;  ///< its place, the first in reading order

  void add(Number difference, std::size_t place) {
    const Number size = difference < 0 ? -difference : difference;
    ++values;
    sum += difference;
    sum_abs += size;
    sum_squares += difference * difference;
    if (size > most) {
      most = size;
      most_at = place;
    }
  }

  /// What comes later in reading order.
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
/// `values` is how many there are; value_at(i) as in float_ranks.h.
template <class ValueAt>
double percentile_95(std::size_t size, const ValueAt& value_at, std::uint64_t values) {
  if (values == 0) return 0.0;
  // The smallest whole number that is not below 95 % of the values, counted from 0.
  const std::uint64_t rank = values - values / 20 - 1;
  return static_cast<double>(value_of_rank(size, value_at, count_upper_halves(size, value_at), rank));
}

}  // namespace alidade
