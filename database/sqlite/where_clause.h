// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "cloud/point_cloud.h"

namespace alidade::database {

/// A condition on the attributes of points in SQLite's SQL, as it follows WHERE: "classification = 2 AND
/// intensity > 100", "z BETWEEN 3 AND 5" or "return_number IN (1, 2)".
/// Columns are those of a cloud's table: x, y, z, and stored_columns() except for the number of the point
/// (database/stored_column.h). Functions include dist_ray() and dist_plane() (database/sqlite/functions.h).
/// A condition that is NULL does not hold.
class WhereClause {
 public:
  /// Errors: not a condition by SQLite's grammar; more than one statement; a parameter; values that may
  /// differ each time: random(), the current time, the time zone of the machine. Columns are not resolved:
  /// they are not known without a cloud.
  explicit WhereClause(std::string text);

  const std::string& text() const { return text_; }

  /// Sets the mark of each row to 1 if the condition holds, else to 0. Errors: a column that the cloud lacks,
  /// with a list of its columns; those of SQLite's evaluation. Cancelled, if `is_given_up` returns true;
  /// several threads call it, also while SQLite evaluates one row. Cost: some 0.2 us per row, shared by the
  /// threads of the task arena (oneTBB).
  void mark(const PointCloud& cloud, std::span<std::uint8_t> marks,
            const std::function<bool()>& is_given_up = {}) const;

 private:
  std::string text_;
};

}  // namespace alidade::database
