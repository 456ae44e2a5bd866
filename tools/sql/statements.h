// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "database/sqlite/sqlite_api.h"

namespace alidade {

/// How rows are printed. Real numbers have as many digits as tell them from every other one, and always a dot
/// or an exponent.
enum class RowForm {
  table,  ///< for people: columns aligned by the first 1000 rows, numbers to the right; NULL, blobs as
          ///< x'00ff'
  csv,    ///< a header, then a row per line; NULL is an empty cell, a blob hexadecimal
  json    ///< an array of an object per row; NULL and what is not finite are null, a blob hexadecimal text
};

/// Prints the rows of one statement on stdout, some at a time.
class RowWriter {
 public:
  virtual ~RowWriter() = default;

  virtual void begin(const std::vector<std::string>& columns) = 0;
  /// The row that the statement is at.
  virtual void row(sqlite3_stmt* statement) = 0;
  virtual void end() = 0;
};

std::unique_ptr<RowWriter> make_row_writer(RowForm form);

}  // namespace alidade
