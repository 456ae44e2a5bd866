// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "cloud/point_cloud.h"
#include "image/point_color.h"

// One number per point, wherever it lies: in a column of a cloud, in an index file's map, or in an octree.

namespace alidade::image {

/// Values of some points.
struct ValueBlock {
  std::span<const double> values;
  std::uint64_t first_id = 0;          ///< point ids count up from here ...
  std::span<const std::uint32_t> ids;  ///< ... unless they are listed here

  std::uint64_t id(std::size_t i) const { return ids.empty() ? first_id + i : ids[i]; }
};

/// Called from many threads at a time.
using VisitBlock = std::function<void(const ValueBlock& block)>;

/// The numbers of all points of a cloud. A value that is not finite, beyond k_largest_value, or marked by the
/// file as none is NaN.
struct PointValues {
  std::uint64_t count = 0;
  /// Visits every point once, in blocks of some thousands at most, in any order.
  std::function<void(const VisitBlock& visit)> for_each_block;
};

/// Whether the values of an extra dimension are numbers, not bytes without meaning.
bool has_numbers(const ExtraColumn& column);

/// The extra dimension of that name that has numbers; null if there is none.
const ExtraColumn* find_numbers(const AttributeColumns& columns, std::string_view name);

/// The values that this coloring shows, `heights` if it is the height; the columns must outlive it. Requires
/// that it shows numbers and that the cloud has them (image/color_points.h). A number of returns of 0, which
/// means none given, is NaN.
PointValues values_of(const PointColoring& coloring, const AttributeColumns& columns,
                      const PointValues& heights);

/// The extent of a column of numbers. NaN values are ignored.
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

/// Position of a value between the ends of a range: 0 at the low end and below, 1 at the high one and above,
/// one half where both are equal; NaN for NaN.
double position_in(const ValueRange& range, double value);

}  // namespace alidade::image
