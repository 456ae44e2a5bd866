// SPDX-License-Identifier: MIT
#include "base/csv_table.h"

#include <fmt/format.h>
#include <algorithm>

#include "base/error.h"
#include "base/words.h"

namespace alidade {

CsvTable::CsvTable(InputFile& file, const ColumnOf& column_of, std::string form)
    : file_(file), scanner_(file), form_(std::move(form)) {
  std::optional<std::string_view> line = scanner_.next_line();
  while (line && trim(*line).empty()) line = scanner_.next_line();
  if (!line) return;
  split_cells(*line, ',', cells_);
  require_few_columns(scanner_, cells_.size());
  if (parse_number(cells_.front())) fail("missing header", form_, quote(*line));
  for (const std::string_view name : cells_) {
    const std::optional<std::size_t> column = column_of(name);
    if (!column) fail("unknown column " + quote(name), form_);
    if (has(*column)) fail(fmt::format("duplicate column {}", name));
    columns_.push_back(*column);
  }
}

bool CsvTable::next() {
  while (const std::optional<std::string_view> line = scanner_.next_line()) {
    if (trim(*line).empty()) continue;
    split_cells(*line, ',', cells_);
    if (cells_.size() == columns_.size()) return true;
    fail(cells_.size() > columns_.size() ? "too many columns" : "too few columns",
         std::to_string(columns_.size()), std::to_string(cells_.size()));
  }
  return false;
}

bool CsvTable::has(std::size_t column) const {
  return std::ranges::find(columns_, column) != columns_.end();
}

std::string CsvTable::source() const {
  return fmt::format("{}:line {}", file_.name(), scanner_.line_number());
}

void CsvTable::fail(std::string problem, std::string expected, std::string found) const {
  scanner_.fail(std::move(problem), std::move(expected), std::move(found));
}

void CsvTable::fail_as_empty(const std::string& what) const {
  throw Error(
      {.file = file_.name(),
       .problem = "contains no " + what,
       .expected = columns_.empty() ? "CSV with the header " + form_ : "one row for each after the header"});
}

}  // namespace alidade
