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

/// How PostgreSQL keeps a column.
enum class ServerType { smallint, integer, bigint, real, double_precision, numeric, bytea };

/// The smallest type that holds all values of the column; ids are bigint.
ServerType server_type(const StoredColumn& column);

/// What stands between the brackets of CREATE TABLE, as produced by stored_columns().
std::string server_columns(const std::vector<StoredColumn>& columns);

/// The statement that makes the index which lets distances leave blocks of a table unread; the name is quoted
/// already.
std::string server_index(const std::string& quoted_name);

/// Errors: a name that is empty, longer than 40 bytes or has control characters. PostgreSQL keeps 63 bytes of
/// a name, and what belongs to a cloud has the table's name with something behind.
void check_server_table(const std::string& name);

/// Errors: more columns than PostgreSQL has room for, 1600 with x, y and z.
void check_column_count(const std::vector<StoredColumn>& columns);

// Beside a cloud NAME on a server stands the table NAME_cloud. Its one row says what the points' rows cannot:
//   version                           of this table: 1
//   scale_x .. scale_z, offset_x .. offset_z  the lattice
//   points                            how many there are
//   min_x .. min_z, max_x .. max_z    a box around them; NULL if there are none
//   crs                               WKT
//   geotiff_keys, geotiff_doubles, geotiff_ascii  bytes, little endian
//   gps_time_is_standard

inline constexpr int k_cloud_row_version = 1;

/// What the row says.
struct CloudRow {
  Lattice lattice;
  std::uint64_t point_count = 0;
  Bounds box;
  Crs crs;
  bool gps_time_is_standard = false;  ///< as PointCloud's
};

/// Of a cloud that was read piece by piece, with a box around its points.
CloudRow cloud_row(const PiecewiseCloud& whole, const Bounds& box);

/// The statement that makes the table of that name, which is quoted already.
std::string cloud_row_table(const std::string& quoted_name);

/// The statement that fills it. A WKT that PostgreSQL does not accept as text (UTF-8 without NUL) is left out.
std::string cloud_row_insert(const std::string& quoted_name, const CloudRow& row);

/// A condition of SQL on x, y, z that holds wherever one of the filters does, and hardly anywhere else:
/// limits are widened by more than rounding, a billionth of them and of a unit and a trillionth of the
/// coordinates. It is made of comparisons that alidade_pg's indexes serve. "false" without filters.
std::string filter_condition(std::span<const PointFilter> any_of);

}  // namespace alidade::database
