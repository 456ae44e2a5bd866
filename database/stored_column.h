// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade::database {

/// A column of a cloud's table other than x, y and z, and the location of its values in a pointcloud table:
/// blob `blob` of every chunk has `size` bytes per point, and the column's number begins at byte `byte` of
/// them.
struct StoredColumn {
  std::string name;
  int blob = 0;
  int size = 0;  ///< bytes per point of the blob
  int byte = 0;
  ScalarType type = ScalarType::uint8;
  double scale = 1.0, offset = 0.0;  ///< value = offset + scale * number, or the number if 1 and 0
  /// The number that marks missing values, NULL in SQL. Widened to 8 bytes, as in ExtraDimension.
  std::optional<std::array<std::uint8_t, 8>> no_data{};

  bool is_scaled() const { return scale != 1.0 || offset != 0.0; }
  /// Whether SQL has integers for it; or bytes.
  bool is_whole() const { return type != ScalarType::float32 && type != ScalarType::float64 && !is_scaled(); }
};

/// Values of one blob, by row of a cloud.
struct ValueBlob {
  const std::byte* values = nullptr;
  std::size_t size = 0;    ///< bytes per point
  std::size_t number = 0;  ///< of the attribute's bit; of extra dimensions theirs, after all bits

  bool is(Attribute attribute) const { return number == number_of(attribute); }
  static constexpr std::size_t number_of(Attribute attribute) {
    return static_cast<std::size_t>(std::countr_zero(static_cast<std::uint32_t>(attribute)));
  }
};

/// All blobs but the first, which holds ids; in the order of stored_columns(). The columns must outlive them.
/// Colours of 8 bits have no values.
std::vector<ValueBlob> value_blobs(const AttributeColumns& columns);

/// The columns of a standard attribute, all in one blob, one after another, as in PointCloud.
struct AttributeParts {
  ScalarType type = ScalarType::uint8;
  std::vector<const char*> names{};
};

/// Requires any attribute but Attribute::extra_dimensions.
AttributeParts attribute_parts(Attribute attribute);

/// Columns that hold all attributes of a cloud, blob by blob: id, then those that `info` names in its order
/// (color as red, green, blue), then the extra dimensions. A name that SQL cannot distinguish from an earlier
/// one or from one of PostgreSQL's own gets a number appended; long ones are cut to 63 bytes, as in
/// PostgreSQL; control characters and bytes that are not UTF-8 become '_'.
std::vector<StoredColumn> stored_columns(const PointCloud& cloud);
std::vector<StoredColumn> stored_columns(const AttributeColumns& columns);
/// As stored_columns() of a cloud with these attributes and extra dimensions.
std::vector<StoredColumn> stored_columns(AttributeSet attributes, std::vector<ExtraDimension> dimensions);

/// The name that the column number_of_returns had in tables of earlier versions.
inline constexpr std::string_view k_earlier_number_of_returns = "return_count";

/// Gives the columns of a table of an earlier version the names of stored_columns().
void rename_earlier_columns(std::vector<StoredColumn>& columns);

/// The name of a column that only queries along a line have, such as "dist", beside those of a cloud: an
/// attribute of that name keeps it, and the column is "ray_dist".
std::string line_column(const std::vector<StoredColumn>& columns, std::string name);

/// The value of a number in a blob for SQL: NULL (std::monostate) if it marks a missing value; an integer,
/// unsigned only if it does not fit a signed one; a real number, as are all values of a column with scale or
/// offset; or bytes.
using ColumnValue =
    std::variant<std::monostate, std::int64_t, std::uint64_t, double, std::span<const std::byte>>;

/// The value of the number, or of the column.size bytes, at `at`.
ColumnValue stored_value(const StoredColumn& column, const std::byte* at);

/// A column of a cloud in memory, with its name and values in SQL.
struct CloudColumn {
  StoredColumn like{};                ///< of a coordinate only the name
  const std::byte* values = nullptr;  ///< of the first row; null: a coordinate
  int axis = 0;                       ///< of a coordinate
};

/// x, y and z, then stored_columns() except for the number of the point. The cloud must outlive them and keep
/// its rows. Requires colours of 16 bits (ColorColumn::deep()), as all clouds with a span of positions have.
std::vector<CloudColumn> cloud_columns(const PointColumns& cloud);

/// The value of a row: a real number for coordinates, else as stored_value().
inline ColumnValue value_of(const PointColumns& cloud, const CloudColumn& column, std::size_t row) {
  if (column.values == nullptr) return cloud.world(row)[column.axis];
  return stored_value(column.like, column.values + row * static_cast<std::size_t>(column.like.size));
}

}  // namespace alidade::database
