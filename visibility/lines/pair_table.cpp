// SPDX-License-Identifier: MIT
#include "visibility/lines/pair_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "base/text_scanner.h"

namespace alidade {
namespace {

constexpr std::string_view k_form =
    "from,to, or from_x,from_y,to_x,to_y[,from_z][,to_z][,from_height][,to_height][,from][,to]";

/// What a column is of each end; the first end's columns stand before the second's.
enum Column { name_column, x_column, y_column, z_column, height_column, k_end_columns };
constexpr std::array<std::string_view, 2 * k_end_columns> k_columns{
    "from", "from_x", "from_y", "from_z", "from_height", "to", "to_x", "to_y", "to_z", "to_height"};

struct Header {
  std::vector<std::size_t> columns;  ///< of every cell, in k_columns
  bool has(std::size_t column) const { return std::ranges::find(columns, column) != columns.end(); }
  bool has_places() const { return has(x_column); }
};

Header read_header(const TextScanner& scanner, std::string_view line) {
  std::vector<std::string_view> names;
  split_cells(line, ',', names);
  require_few_columns(scanner, names.size());
  Header header;
  for (const std::string_view name : names) {
    const auto found = std::ranges::find(k_columns, name);
    if (found == k_columns.end()) scanner.fail("unknown column " + quote(name), std::string(k_form));
    const auto column = static_cast<std::size_t>(found - k_columns.begin());
    if (header.has(column)) scanner.fail(fmt::format("column {} stands twice", name));
    header.columns.push_back(column);
  }
  bool any_place = false, all_places = true, all_names = true;
  for (const std::size_t end : {std::size_t{0}, std::size_t{k_end_columns}}) {
    all_places = all_places && header.has(end + x_column) && header.has(end + y_column);
    all_names = all_names && header.has(end + name_column);
    for (std::size_t column = x_column; column < k_end_columns; ++column)
      any_place = any_place || header.has(end + column);
  }
  if (any_place ? !all_places : !all_names)
    scanner.fail("columns are missing", std::string(k_form), quote(line));
  return header;
}

void take_cell(const TextScanner& scanner, std::size_t column, std::string_view cell, GivenPair& pair) {
  GivenObserver& end = column < k_end_columns ? pair.from : pair.to;
  const std::size_t meaning = column % k_end_columns;
  if (meaning == name_column) {
    end.name = cell;
    return;
  }
  if (cell.empty() && (meaning == z_column || meaning == height_column)) return;
  const std::optional<double> number = parse_number(cell);
  if (!number || !std::isfinite(*number))
    scanner.fail(fmt::format("{} is not a finite number", k_columns[column]), "a number",
                 cell.empty() ? "nothing" : quote(cell));
  if (meaning == x_column) end.place.x = *number;
  if (meaning == y_column) end.place.y = *number;
  if (meaning == z_column) end.z = *number;
  if (meaning == height_column) end.height = *number;
}

GivenPair read_row(const TextScanner& scanner, std::string_view line, const Header& header,
                   const std::string& file) {
  std::vector<std::string_view> cells;
  split_cells(line, ',', cells);
  if (cells.size() != header.columns.size()) {
    scanner.fail(cells.size() > header.columns.size() ? "too many cells" : "too few cells",
                 std::to_string(header.columns.size()), std::to_string(cells.size()));
  }
  GivenPair pair;
  pair.from.source = pair.to.source = fmt::format("{}:line {}", file, scanner.line_number());
  pair.has_places = header.has_places();
  for (std::size_t i = 0; i < cells.size(); ++i) take_cell(scanner, header.columns[i], cells[i], pair);
  if (!pair.has_places && (pair.from.name.empty() || pair.to.name.empty()))
    scanner.fail("an end has no name", "names of places");
  return pair;
}

}  // namespace

std::vector<GivenPair> read_pair_table(const std::filesystem::path& path) {
  InputFile file(path);
  TextScanner scanner(file);
  std::optional<Header> header;
  std::vector<GivenPair> pairs;
  while (const std::optional<std::string_view> line = scanner.next_line()) {
    if (trim(*line).empty()) continue;
    if (header)
      pairs.push_back(read_row(scanner, *line, *header, path.string()));
    else
      header = read_header(scanner, *line);
  }
  if (pairs.empty()) {
    throw Error({.file = path.string(),
                 .problem = "holds no pairs",
                 .expected = header ? "a row for each behind the header"
                                    : "CSV with the header " + std::string(k_form)});
  }
  return pairs;
}

}  // namespace alidade
