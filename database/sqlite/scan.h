// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "database/point_cursor.h"
#include "database/sqlite/sqlite_api.h"

namespace alidade::database {

// The plan of a scan of a cloud's table: the conditions that SQLite passes, and the filter that they make.

/// The columns of a cloud's table by their numbers: the first stored one (id), x, y, z, the other stored
/// ones; hidden ox, oy, oz, dx, dy, dz, _chunk, dist, t, under the names of line_column().
class TableColumns {
 public:
  enum class Kind { stored, axis, argument, chunk, distance, t };

  static constexpr int k_hidden = 9;

  /// `stored` must outlive it. Requires at least one.
  explicit TableColumns(const std::vector<StoredColumn>& stored) : stored_(stored) {}

  Kind kind(int column) const;
  const StoredColumn& stored(int column) const {
    return stored_[static_cast<std::size_t>(column == 0 ? 0 : column - 3)];
  }
  int axis(int column) const { return column - 1; }
  std::size_t argument(int column) const { return static_cast<std::size_t>(column - first_hidden()); }

  /// Number of columns.
  int size() const { return first_hidden() + k_hidden; }
  /// CREATE TABLE with all columns.
  std::string declaration() const;

 private:
  int first_hidden() const { return static_cast<int>(stored_.size()) + 3; }

  const std::vector<StoredColumn>& stored_;
};

/// The form with a ray, for messages.
inline constexpr const char* k_ray_form = "FROM TABLE(ox, oy, oz, dx, dy, dz)";

/// A row id is the number of a chunk and, in the lowest bits, of the row in it.
inline constexpr int k_row_bits = 20;

/// Origin and direction of the form table(ox, oy, oz, dx, dy, dz), if it was used.
using Arguments = std::optional<std::array<double, 6>>;

/// Chooses the plan of a scan (xBestIndex). Its text, idxStr, has the conditions, which plan_filter() reads;
/// its number, idxNum, is the RowOrder. If fewer than six arguments are given, they are conditions on columns
/// that only the form with a ray has. Returns SQLite's code: SQLITE_CONSTRAINT if arguments come from a table
/// that is read later. Errors: a number for _chunk beside a ray.
int choose_plan(const TableColumns& columns, std::uint64_t point_count, sqlite3_index_info& info);

/// The filter of a scan, and its arguments; empty if no row can be an answer. Limits are closed: SQLite
/// checks each row once more. Errors: arguments that are not a ray; a value that is not a limit for
/// in_chunk().
std::optional<ScanFilter> plan_filter(const char* plan, std::span<sqlite3_value* const> values,
                                      Arguments& arguments);

}  // namespace alidade::database
