// SPDX-License-Identifier: MIT
#include "tools/query/parse_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "base/text_scanner.h"
#include "tools/query/check_row.h"

namespace alidade {
namespace {

std::size_t offset_in(const TextLine& line, std::string_view cell) {
  return static_cast<std::size_t>(cell.data() - line.text.data());
}

std::string count_of(std::size_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace

std::vector<std::size_t> read_header(const TextLine& line, const TargetKind& kind) {
  std::vector<std::string_view> names;
  split_cells(line.text, ',', names);
  if (parse_number(names.front()))
    line.fail(0, "there is no header", "a line of names: " + kind.form(), quote(line.text));
  std::vector<std::size_t> columns;
  for (const std::string_view name : names) {
    const std::size_t column = kind.column(name);
    if (column == kind.columns.size()) {
      line.fail(offset_in(line, name), fmt::format("unknown column {}", quote(name)),
                "some of " + kind.names());
    }
    if (std::ranges::find(columns, column) != columns.end())
      line.fail(offset_in(line, name), fmt::format("column {} stands twice", name));
    columns.push_back(column);
  }
  for (std::size_t i = 0; i < kind.columns.size(); ++i) {
    if (kind.columns[i].required && std::ranges::find(columns, i) == columns.end())
      line.fail(line.text.size(), fmt::format("column {} is missing", kind.columns[i].name), kind.form());
  }
  return columns;
}

std::vector<std::size_t> columns_in_order(const TextLine& line, const TargetKind& kind) {
  std::vector<std::string_view> cells;
  split_cells(line.text, ',', cells);
  if (cells.size() < kind.required_count() || cells.size() > kind.columns.size()) {
    line.fail(0, fmt::format("not a {}", kind.name), kind.form(), count_of(cells.size(), "value"));
  }
  std::vector<std::size_t> columns(cells.size());
  std::iota(columns.begin(), columns.end(), std::size_t{0});
  return columns;
}

void parse_cells(const TextLine& line, const TargetKind& kind, std::span<const std::size_t> column_of_cell,
                 std::span<double> row) {
  std::vector<std::string_view> cells;
  cells.reserve(column_of_cell.size());
  split_cells(line.text, ',', cells);
  if (cells.size() != column_of_cell.size()) {
    const bool surplus = cells.size() > column_of_cell.size();
    line.fail(surplus ? offset_in(line, cells[column_of_cell.size()]) : line.text.size(),
              surplus ? "too many columns" : "too few columns", std::to_string(column_of_cell.size()),
              std::to_string(cells.size()));
  }
  std::array<std::size_t, k_most_target_columns> offsets{};
  std::ranges::fill(row, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const TargetColumn& column = kind.columns[column_of_cell[i]];
    const std::size_t offset = offset_in(line, cells[i]);
    offsets[column_of_cell[i]] = offset;
    if (cells[i].empty() && !column.required) continue;
    const auto number = parse_number(cells[i]);
    if (!number) {
      line.fail(offset, fmt::format("{} is not a number", column.name), "a number",
                cells[i].empty() ? "nothing" : quote(cells[i]));
    }
    check_value(line, offset, column, *number, cells[i]);
    row[column_of_cell[i]] = *number;
  }
  check_row(line, kind, row, std::span(offsets).first(row.size()));
}

}  // namespace alidade
