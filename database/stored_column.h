// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade::database {

/// What a column of a cloud's table is, beside x, y, z, and where its values lie in a pointcloud table: in
/// blob `blob` of every chunk, `size` bytes per point, of which the column's number is those at `offset`.
struct StoredColumn {
  std::string name;
  int blob = 0;
  int size = 0;  ///< bytes per point of the blob
  int byte = 0;  ///< of the first of these bytes, within a point
  ScalarType type = ScalarType::uint8;
  double scale = 1.0, offset = 0.0;  ///< value = offset + scale * number, unless 1 and 0
  /// The number that means no value: NULL. As ExtraDimension's: widened to 8 bytes.
  std::optional<std::array<std::uint8_t, 8>> no_data{};
};

/// What columns a standard attribute becomes; all in one blob, one behind the other, as in PointCloud.
struct AttributeParts {
  ScalarType type = ScalarType::uint8;
  std::vector<const char*> names{};
};

/// Requires another one than Attribute::extra_dimensions.
AttributeParts attribute_parts(Attribute attribute);

/// Columns that hold all attributes of a cloud, blob by blob: id, then those that `info` names in its order
/// (color as red, green, blue), then the extra dimensions. A name that SQL cannot distinguish from an earlier
/// one or from one of PostgreSQL's own gets a number behind it; of long ones, 63 bytes are kept, as
/// PostgreSQL does; control characters and what is no UTF-8 become '_'.
std::vector<StoredColumn> stored_columns(const PointCloud& cloud);
/// The same of a cloud with these attributes and extra dimensions.
std::vector<StoredColumn> stored_columns(AttributeSet attributes, std::vector<ExtraDimension> dimensions);

/// The name of a column that only queries along a line have, such as "dist", beside those of a cloud: an attribute of that
/// name keeps it, and the column is "ray_dist".
std::string line_column(const std::vector<StoredColumn>& columns, std::string name);

/// What SQL sees of a number in a blob: nothing (NULL) where it is the mark for no value; a whole number, the
/// second kind for those beyond the first; a real number, as all of a column with scale or offset are; bytes.
using ColumnValue =
    std::variant<std::monostate, std::int64_t, std::uint64_t, double, std::span<const std::byte>>;

/// The value whose number is at `at`, or which are column.size bytes there.
ColumnValue stored_value(const StoredColumn& column, const std::byte* at);

}  // namespace alidade::database
