// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "database/sqlite/scan.h"
#include "database/sqlite/sqlite_api.h"
#include "database/stored_column.h"

// How a scan of a cloud's table is planned: which conditions SQLite hands over, and what filter they make.

namespace alidade {

/// The columns of a cloud's table by their numbers: the first stored one (id), x, y, z, the other stored
/// ones; hidden ox, oy, oz, dx, dy, dz, _chunk, dist, t.
class TableColumns {
 public:
  enum class Kind { stored, axis, argument, chunk, distance, t };

  /// `stored` must outlive it. Requires at least one.
  explicit TableColumns(const std::vector<StoredColumn>& stored) : stored_(stored) {}

  Kind kind(int column) const;
  const StoredColumn& stored(int column) const {
    return stored_[static_cast<std::size_t>(column == 0 ? 0 : column - 3)];
  }
  int axis(int column) const { return column - 1; }
  std::size_t argument(int column) const { return static_cast<std::size_t>(column - first_hidden()); }

  /// CREATE TABLE with all of them.
  std::string declaration() const;

 private:
  int first_hidden() const { return static_cast<int>(stored_.size()) + 3; }

  const std::vector<StoredColumn>& stored_;
};

/// How the form with a ray is written.
inline constexpr const char* k_ray_form = "cloud(ox, oy, oz, dx, dy, dz)";

/// A row id is a chunk and the row in it.
inline constexpr int k_row_bits = 20;

/// Origin and direction of the form table(ox, oy, oz, dx, dy, dz), if it was used.
using Arguments = std::optional<std::array<double, 6>>;

/// Says in `info` what a scan uses: conditions become the plan's text, which plan_filter() reads, and its
/// number is the RowOrder. Answers SQLite's code; SQLITE_CONSTRAINT where arguments come from a table that is
/// not read before. Fewer arguments than six are conditions on columns that only a ray has. Errors: a
/// seventh.
int choose_plan(const TableColumns& columns, std::uint64_t point_count, sqlite3_index_info& info);

/// The filter of a scan, and its arguments; empty if no row can be an answer. Limits are closed: SQLite
/// checks each row once more. Errors: arguments that are no ray; what is no limit for in_chunk().
std::optional<ScanFilter> plan_filter(const char* plan, std::span<sqlite3_value* const> values,
                                      Arguments& arguments);

}  // namespace alidade
