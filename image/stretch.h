// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "image/point_values.h"

namespace alidade {

/// What there is in a column of numbers. Values that are NaN count nowhere.
struct ValueExtent {
  ValueRange range;         ///< smallest and largest; 0 and 0 if there is no value
  std::uint64_t count = 0;  ///< of values
};

/// Cost: one pass, in parallel.
ValueExtent extent_of(const PointValues& values);

/// Exact percentiles, 0 <= low <= high <= 100, of a column of `extent.count` values. Sorted, with ranks from
/// 0 to count - 1, they are the values of the ranks low / 100 * (count - 1), rounded down, and
/// high / 100 * (count - 1), rounded up: so 0 and 100 are the smallest and largest value, and where half the
/// values are equal nothing is interpolated. 0 and 0 if there is no value. Cost: four passes in parallel, at
/// most; 1 MB per thread. Source: radix selection on the ordered bits of IEEE 754 numbers.
ValueRange percentiles_of(const PointValues& values, const ValueExtent& extent,
                          const ValueRange& percentiles);

/// Place of a value between the ends of a range: 0 at the low end and below, 1 at the high one and above, one
/// half where both are equal; NaN for NaN.
double place_in(const ValueRange& range, double value);

}  // namespace alidade
