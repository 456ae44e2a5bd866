// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "cloud/point_cloud.h"
#include "database/stored_column.h"

namespace alidade::database {

/// A column of a cloud with its name and values in SQL.
struct CloudColumn {
  StoredColumn like{};                ///< of a coordinate only the name
  const std::byte* values = nullptr;  ///< of the first row; null: a coordinate
  int axis = 0;                       ///< of a coordinate
};

/// x, y and z, then stored_columns() except for the number of the point. The cloud must outlive
/// them and keep its rows. Requires colours of 16 bits (ColorColumn::deep()), which all clouds with
/// a span of positions have.
std::vector<CloudColumn> cloud_columns(const PointColumns& cloud);

/// The value of a row: a real number for coordinates, else as stored_value().
inline ColumnValue value_of(const PointColumns& cloud, const CloudColumn& column, std::size_t row) {
  if (column.values == nullptr) return cloud.world(row)[column.axis];
  return stored_value(column.like, column.values + row * static_cast<std::size_t>(column.like.size));
}

}  // namespace alidade::database
