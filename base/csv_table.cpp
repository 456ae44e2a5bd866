// SPDX-License-Identifier: MIT
#include "base/csv_table.h"

#include <fmt/format.h>
#include <algorithm>

#include "base/error.h"
#include "base/words.h"

namespace alidade {

namespace {

/// The hint for names that are often given but are not columns.
std::string hint_for(std::string_view name) {
  const std::string word = lower_case(name);
  for (const char* const angle : {"lon", "lat", "longitude", "latitude", "lng"})
    if (word == angle) return ", where longitude is x and latitude y (in EPSG:4326)";
  for (const char* const axis : {"easting", "northing", "east", "north"})
    if (word == axis) return ", where the easting is x and the northing y";
  return "";
}

}  // namespace

bool has_decimal_comma(std::string_view cell) {
  return std::ranges::count(cell, ',') == 1 && cell.front() != ',' && cell.back() != ',' &&
         cell.find_first_not_of("+-0123456789,eE ") == cell.npos;
}

std::string_view with_point(std::string_view cell, std::string& room) {
  if (!has_decimal_comma(cell)) return cell;
  room = cell;
  std::ranges::replace(room, ',', '.');
  return room;
}

CsvTable::CsvTable(InputFile& file, const ColumnOf& column_of, std::string form)
    : file_(file), scanner_(file), form_(std::move(form)) {
  std::optional<std::string_view> line = scanner_.next_line();
  while (line && trim(*line).empty()) line = scanner_.next_line();
  if (!line) return;
  for (const char other : {';', '\t'})
    if (line->find(',') == line->npos && line->find(other) != line->npos) separator_ = other;
  split(*line);
  require_few_columns(scanner_, cells_.size());
  if (parse_number(cells_.front())) fail("missing header", form_, quote(*line));
  for (const std::string_view name : cells_) {
    const std::optional<std::size_t> column = column_of(name);
    if (!column) fail("unknown column " + quote(name), form_ + hint_for(name), "the columns " + quote(*line));
    if (has(*column)) fail(fmt::format("duplicate column {}", name));
    columns_.push_back(*column);
  }
}

bool CsvTable::next() {
  while (const std::optional<std::string_view> line = scanner_.next_line()) {
    if (trim(*line).empty()) continue;
    split(*line);
    if (cells_.size() == columns_.size()) return true;
    const char* const separator = separator_ == ',' ? "commas" : separator_ == ';' ? "semicolons" : "tabs";
    fail(cells_.size() > columns_.size() ? "too many columns" : "too few columns",
         fmt::format("{}, separated by {} as in the header", columns_.size(), separator),
         fmt::format("{} in {}", cells_.size(), quote(*line)));
  }
  return false;
}

void CsvTable::split(std::string_view line) {
  split_cells(line, separator_, cells_);
  if (separator_ == ',') return;
  numbers_.clear();
  for (std::string_view& cell : cells_)
    if (has_decimal_comma(cell)) cell = with_point(cell, numbers_.emplace_back());
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
