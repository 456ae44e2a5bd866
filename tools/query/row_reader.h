// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/query/line_source.h"
#include "tools/query/target_kind.h"

namespace alidade::tools {

/// Targets as numbers: a row for each line that is not blank, with a value for every column of the kind; NaN
/// where an optional one was not given. Every value has been checked by its column's rule.
struct TargetRows {
  std::size_t column_count = 0;
  std::vector<double> values;
  std::vector<std::uint64_t> lines;  ///< of every row, from 1

  std::size_t size() const { return lines.size(); }
  std::span<const double> row(std::size_t i) const {
    return std::span(values).subspan(i * column_count, column_count);
  }
};

/// Reads rows of numbers from CSV with a header of column names in any order, from JSON lines (objects with
/// column names as keys, or arrays in the kind's order), or from the command line (in the kind's order). CSV
/// and JSON are distinguished by the first character of the text. Lines are parsed in parallel. Memory: some
/// mebibytes.
class RowReader {
 public:
  /// Reads the first lines. Errors: the source's; the text is empty, or its header is wrong.
  RowReader(LineSource source, const TargetKind& kind);

  /// The rows of the next lines, maybe none; false at the end. Errors name source, line and column; of
  /// several the first one in the text.
  bool next(TargetRows& rows);

  /// Share of the text that is used if this share of the last rows is used, both 0 .. 1; 0 if the size of the
  /// text is not known.
  double share(double of_last_rows) const;

  /// Throws an Error of the rows from this line on as a whole.
  [[noreturn]] void fail(std::uint64_t line, std::string problem, std::string expected = {},
                         std::string found = {}) const;

 private:
  enum class Form { csv, json_lines, in_order };

  TextLine line(std::size_t i) const;
  void begin();
  void parse(const TextLine& text, std::span<double> row) const;

  LineSource source_;
  const TargetKind* kind_;
  Form form_ = Form::in_order;
  std::vector<std::size_t> column_of_cell_;  ///< of CSV
  LineBlock block_;
  std::size_t used_ = 0;  ///< lines of the block before its first row
  bool has_block_ = false;
};

}  // namespace alidade::tools
