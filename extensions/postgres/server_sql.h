// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cloud/read_in_pieces.h"
#include "database/point_filter.h"
#include "database/stored_column.h"

// A cloud as a table of a PostgreSQL server: columns id, x, y, z, then the other stored ones.

namespace alidade::database {

/// Type of a column in PostgreSQL.
enum class ServerType { smallint, integer, bigint, real, double_precision, numeric, bytea };

/// The smallest type that holds all values of the column; ids are bigint.
ServerType server_type(const StoredColumn& column);

/// The column definitions of CREATE TABLE for stored_columns().
std::string server_columns(const std::vector<StoredColumn>& columns);

/// The statement that makes the index by which conditions on distances skip blocks of a table.
std::string server_index(const std::string& quoted_name);

/// Errors: a name that is empty, longer than 40 bytes or has control characters. PostgreSQL keeps 63 bytes of
/// a name, and the objects of a cloud have the table's name with a suffix.
void check_server_table(const std::string& name);

/// Errors: more columns than PostgreSQL supports, 1600 with x, y and z.
void check_column_count(const std::vector<StoredColumn>& columns);

// A cloud NAME on a server has a second table NAME_cloud. Its one row has the data that are not of points:
//   version                           of this table: 1
//   scale_x .. scale_z, offset_x .. offset_z  the lattice
//   points                            number of points
//   min_x .. min_z, max_x .. max_z    a box around them; NULL if there are none
//   crs                               WKT
//   geotiff_keys, geotiff_doubles, geotiff_ascii  bytes, little endian
//   gps_time_is_standard

inline constexpr int k_cloud_row_version = 1;

/// The data of that row.
struct CloudRow {
  Lattice lattice;
  std::uint64_t point_count = 0;
  Bounds box;
  Crs crs;
  bool gps_time_is_standard = false;  ///< PointCloud::gps_time_is_standard
};

/// The row of a cloud that was read piece by piece, with a box around its points.
CloudRow cloud_row(const PiecewiseCloud& whole, const Bounds& box);

/// The statement that makes a table NAME_cloud.
std::string cloud_row_table(const std::string& quoted_name);

/// The statement that inserts its row. A WKT that PostgreSQL does not accept as text (UTF-8 without NUL) is
/// left out.
std::string cloud_row_insert(const std::string& quoted_name, const CloudRow& row);

/// A condition of SQL on x, y, z that holds if one of the filters does, and for few other points:
/// limits are widened by more than rounding, a billionth of them and of a unit and a trillionth of the
/// coordinates. It consists of comparisons that alidade_pg's indexes support. "false" without filters.
std::string filter_condition(std::span<const PointFilter> any_of);

}  // namespace alidade::database
