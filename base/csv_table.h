// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/text_scanner.h"

namespace alidade {

/// Whether a cell is a number with a decimal comma between digits, which is unambiguous where no comma
/// separates cells.
bool has_decimal_comma(std::string_view cell);

/// The cell; if it has a decimal comma, a copy in `room` with a point instead.
std::string_view with_point(std::string_view cell, std::string& room);

/// A table as CSV: a header with the names of columns in any order, then rows with a cell for each. Blank
/// lines are skipped. Columns are separated by commas, or, where the header has none, by semicolons or tabs;
/// numbers may then have decimal commas. Errors name file and line.
///
///   CsvTable table(file, column_of, "x,y[,z]");
///   while (table.next()) use(table.columns(), table.cells());
class CsvTable {
 public:
  /// The number of the column with this name; empty for an unknown name.
  using ColumnOf = std::function<std::optional<std::size_t>(std::string_view name)>;

  /// Reads the header; a file without lines has no columns. `form` describes the header in messages. Errors:
  /// numbers instead of names; an unknown or duplicate column; more than k_most_columns; those of InputFile.
  CsvTable(InputFile& file, const ColumnOf& column_of, std::string form);

  /// Reads the next row; false at the end. Errors: more or fewer cells than columns.
  bool next();

  /// Columns in the order of the header, by number.
  const std::vector<std::size_t>& columns() const { return columns_; }
  bool has(std::size_t column) const;
  /// Cells of the row last read, valid until the next one.
  const std::vector<std::string_view>& cells() const { return cells_; }

  /// "table.csv:line 3".
  std::string source() const;
  /// Throws the Error for the line last read.
  [[noreturn]] void fail(std::string problem, std::string expected = {}, std::string found = {}) const;
  /// The Error of a table without rows of `what`.
  [[noreturn]] void fail_as_empty(const std::string& what) const;

 private:
  void split(std::string_view line);

  InputFile& file_;
  TextScanner scanner_;
  char separator_ = ',';
  std::deque<std::string> numbers_;  ///< of the row, whose decimal commas have become points
  std::string form_;
  std::vector<std::size_t> columns_;
  std::vector<std::string_view> cells_;
};

}  // namespace alidade
