// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "cloud/point_cloud.h"
#include "image/point_color.h"

// One number per point, read from where it is stored: a column of a cloud, a mapped index file or an octree.

namespace alidade::image {

/// Values of some points: values[i] belongs to the point id(i).
struct ValueBlock {
  std::span<const double> values;
  std::uint64_t first_id = 0;          ///< point ids count up from here ...
  std::span<const std::uint32_t> ids;  ///< ... unless they are listed here

  std::uint64_t id(std::size_t i) const { return ids.empty() ? first_id + i : ids[i]; }
};

/// Called from many threads at once.
using VisitBlock = std::function<void(const ValueBlock& block)>;

/// One number for each point of a cloud; NaN for values that are not finite, exceed k_largest_value in
/// magnitude or are marked as nodata by the file.
struct PointValues {
  std::uint64_t count = 0;  ///< of points
  /// Visits each point once, in blocks of some thousand points at most, in any order.
  std::function<void(const VisitBlock& visit)> for_each_block;
};

/// Whether the values of an extra dimension are numbers, not opaque bytes.
bool has_numbers(const ExtraColumn& column);

/// The extra dimension of that name, if its values are numbers; else null.
const ExtraColumn* find_numbers(const AttributeColumns& columns, std::string_view name);

/// The values that `coloring` shows: a column of `columns`, which must outlive the result, or `heights`.
/// Requires a coloring by numbers, which the cloud has (image/color_points.h). Return numbers and numbers of
/// returns of 0, which are not recorded, are NaN.
PointValues values_of(const PointColoring& coloring, const AttributeColumns& columns,
                      const PointValues& heights);

/// The extent of a column of numbers. NaN values are ignored.
struct ValueExtent {
  ValueRange range;         ///< smallest and largest; 0 and 0 if there is no value
  std::uint64_t count = 0;  ///< of values
};

/// Cost: one parallel pass.
ValueExtent extent_of(const PointValues& values);

/// The values at two percentiles, 0 <= low <= high <= 100, exactly: of the `extent.count` values in ascending
/// order, those with the indices low / 100 * (count - 1), rounded down, and high / 100 * (count - 1), rounded
/// up. Nothing is interpolated; 0 and 100 are the smallest and the largest value. 0 and 0 if there is no
/// value. Requires extent_of(values) as `extent`. Cost: at most four parallel passes. Memory: 1 MB per
/// thread. Source: radix selection on the ordered bits of IEEE 754 numbers.
ValueRange percentiles_of(const PointValues& values, const ValueExtent& extent,
                          const ValueRange& percentiles);

/// Position of a value in a range: 0 at the low end and below, 1 at the high end and above, 0.5 if both ends
/// are equal; NaN for NaN.
double position_in(const ValueRange& range, double value);

}  // namespace alidade::image
