// SPDX-License-Identifier: MIT
#include "tools/query/row_reader.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/json.h"
#include "base/parallel.h"
#include "base/words.h"

namespace alidade::tools {
namespace {

std::size_t offset_in(const TextLine& line, std::string_view cell) {
  return static_cast<std::size_t>(cell.data() - line.text.data());
}

/// The header of a CSV: for every cell the kind's column. Errors: a name that is unknown or is repeated, a
/// required column that is missing, no names at all.
std::vector<std::size_t> read_header(const TextLine& line, const TargetKind& kind) {
  std::vector<std::string_view> names;
  split_cells(line.text, ',', names);
  if (parse_number(names.front()))
    line.fail(0, "missing header", "column names: " + kind.form(), quote(line.text));
  std::vector<std::size_t> columns;
  for (const std::string_view name : names) {
    const std::size_t column = kind.column(name);
    if (column == kind.columns.size()) {
      if (name.find_first_of(";\t") != name.npos)
        line.fail(offset_in(line, name), "columns are not separated by commas", kind.form(),
                  quote(line.text));
      line.fail(offset_in(line, name), fmt::format("unknown column {}", quote(name)),
                "one of " + kind.names());
    }
    if (std::ranges::find(columns, column) != columns.end())
      line.fail(offset_in(line, name), fmt::format("duplicate column {}", name));
    columns.push_back(column);
  }
  for (std::size_t i = 0; i < kind.columns.size(); ++i) {
    if (kind.columns[i].required && std::ranges::find(columns, i) == columns.end())
      line.fail(line.text.size(), fmt::format("missing column {}", kind.columns[i].name), kind.form());
  }
  return columns;
}

/// The columns of values without a header, as many as there are: the kind's own order. Errors: too few or too
/// many.
std::vector<std::size_t> columns_in_order(const TextLine& line, const TargetKind& kind) {
  std::vector<std::string_view> cells;
  split_cells(line.text, ',', cells);
  if (cells.size() < kind.required_count() || cells.size() > kind.columns.size())
    line.fail(0, fmt::format("not a {}", kind.name), kind.form(),
              fmt::format("{} value{}", cells.size(), cells.size() == 1 ? "" : "s"));
  std::vector<std::size_t> columns(cells.size());
  std::iota(columns.begin(), columns.end(), std::size_t{0});
  return columns;
}

/// Reads a line of comma-separated numbers into `row`, which holds one value per column of the kind; NaN for
/// those that are not given. An empty cell of an optional column counts as not given. Errors: number of
/// cells; a cell that is not a number or breaks its column's rule; see check_row().
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
      line.fail(offset, fmt::format("invalid {}", column.name), "a number",
                cells[i].empty() ? "nothing" : quote(cells[i]));
    }
    check_value(line, offset, column, *number, cells[i]);
    row[column_of_cell[i]] = *number;
  }
  check_row(line, kind, row, std::span(offsets).first(row.size()));
}

/// The line as a document; errors get the line's own number.
JsonDocument parse_line(const TextLine& line) {
  try {
    return parse_json(std::string(line.text), std::string(line.source));
  } catch (const Error& error) {
    Error::Parts parts = error.parts();
    parts.location = fmt::format("{}{}", line.number, parts.location.substr(parts.location.find(':')));
    throw Error(std::move(parts));
  }
}

class RowFiller {
 public:
  RowFiller(const TextLine& line, const JsonDocument& document, const TargetKind& kind, std::span<double> row)
      : line_(line), document_(document), kind_(kind), row_(row) {
    std::ranges::fill(row_, std::numeric_limits<double>::quiet_NaN());
  }

  void fill() {
    const JsonValue& root = document_.root;
    if (const auto* object = std::get_if<JsonObject>(&root.data)) {
      for (const JsonMember& member : *object) take(member);
    } else if (const auto* array = std::get_if<JsonArray>(&root.data)) {
      if (array->size() < kind_.required_count() || array->size() > kind_.columns.size()) {
        line_.fail(root.begin, fmt::format("not a {}", kind_.name), fmt::format("[{}]", kind_.form()),
                   fmt::format("{} values", array->size()));
      }
      for (std::size_t i = 0; i < array->size(); ++i) put((*array)[i], i);
    } else {
      line_.fail(root.begin, fmt::format("not a {}", kind_.name), "an object or an array", found(root));
    }
    check_row(line_, kind_, row_, std::span(offsets_).first(row_.size()));
  }

 private:
  void take(const JsonMember& member) {
    const std::size_t column = kind_.column(member.key);
    if (column < kind_.columns.size()) return put(member.value, column);
    const auto vector = std::ranges::find(kind_.vectors, std::string_view(member.key), &TargetVector::name);
    if (vector == kind_.vectors.end()) {
      std::string known = kind_.names();
      for (const TargetVector& other : kind_.vectors) known += fmt::format(", {}", other.name);
      line_.fail(member.key_begin, "unknown key " + document_.quote(member.key_begin, member.key_end),
                 "one of " + known);
    }
    const auto* const array = std::get_if<JsonArray>(&member.value.data);
    if (array == nullptr || array->size() != 3) {
      line_.fail(member.value.begin, fmt::format("invalid {}", member.key), "an array of three numbers",
                 found(member.value));
    }
    for (std::size_t i = 0; i < 3; ++i) put((*array)[i], vector->first + i);
  }

  void put(const JsonValue& value, std::size_t i) {
    const TargetColumn& column = kind_.columns[i];
    offsets_[i] = value.begin;
    if (!std::isnan(row_[i])) line_.fail(value.begin, fmt::format("duplicate {}", column.name));
    if (std::holds_alternative<std::nullptr_t>(value.data) && !column.required) return;
    row_[i] = number(value, column);
    check_value(line_, value.begin, column, row_[i], found(value));
  }

  double number(const JsonValue& value, const TargetColumn& column) const {
    if (const auto* real = std::get_if<double>(&value.data)) return *real;
    if (const auto* whole = std::get_if<std::uint64_t>(&value.data)) return static_cast<double>(*whole);
    if (const auto* text = std::get_if<std::string>(&value.data)) {
      if (*text == "inf") return std::numeric_limits<double>::infinity();
      if (*text == "-inf") return -std::numeric_limits<double>::infinity();
    }
    line_.fail(value.begin, fmt::format("invalid {}", column.name), "a number", found(value));
  }

  std::string found(const JsonValue& value) const { return document_.quote(value.begin, value.end); }

  const TextLine& line_;
  const JsonDocument& document_;
  const TargetKind& kind_;
  std::span<double> row_;
  std::array<std::size_t, k_most_target_columns> offsets_{};
};

/// Reads a line of JSON into `row`, which holds one value per column of the kind; NaN for those that are not
/// given. The line is an object whose keys are columns ("ox": 1) or vectors ("origin": [1, 2, 3]) of the
/// kind, or an array in the kind's order. Values are numbers, "inf" or "-inf"; null counts as not given.
/// Errors: no JSON (nested at most 64 deep, no key twice); an unknown key; a value given twice; one that is
/// no number or breaks its column's rule; see check_row().
void parse_json_row(const TextLine& line, const TargetKind& kind, std::span<double> row) {
  const JsonDocument document = parse_line(line);
  RowFiller(line, document, kind, row).fill();
}

constexpr std::size_t k_grain = 512;

bool is_blank_line(std::string_view text) {
  return trim(text).empty();
}

}  // namespace

RowReader::RowReader(LineSource source, const TargetKind& kind) : source_(std::move(source)), kind_(&kind) {
  begin();
}

TextLine RowReader::line(std::size_t i) const {
  return {.source = source_.name(),
          .is_command_line = source_.is_command_line(),
          .text = block_.line(i),
          .number = block_.first_number + i};
}

void RowReader::fail(std::uint64_t number, std::string problem, std::string expected,
                     std::string found) const {
  throw Error({.file = source_.name(),
               .location = source_.is_command_line() ? "" : fmt::format("{}:1", number),
               .problem = std::move(problem),
               .expected = std::move(expected),
               .found = std::move(found)});
}

double RowReader::share(double of_last_rows) const {
  if (source_.total() == 0) return 0.0;
  const double waiting = (1.0 - of_last_rows) * static_cast<double>(block_.text.size());
  return (static_cast<double>(source_.done()) - waiting) / static_cast<double>(source_.total());
}

void RowReader::begin() {
  while (source_.next(block_)) {
    for (used_ = 0; used_ < block_.size() && is_blank_line(block_.line(used_));) ++used_;
    if (used_ == block_.size()) continue;
    has_block_ = true;
    if (source_.is_command_line()) return;
    const TextLine first = line(used_);
    const char character = trim(first.text).front();
    form_ = character == '{' || character == '[' ? Form::json_lines : Form::csv;
    if (form_ == Form::csv) {
      column_of_cell_ = read_header(first, *kind_);
      ++used_;
    }
    return;
  }
  throw Error({.file = source_.name(),
               .location = source_.is_command_line() ? "" : "1:1",
               .problem = fmt::format("contains no {}", kind_->plural),
               .expected = fmt::format("CSV with the header {}, or JSON lines", kind_->form()),
               .found = "nothing"});
}

void RowReader::parse(const TextLine& text, std::span<double> row) const {
  switch (form_) {
    case Form::csv:
      return parse_cells(text, *kind_, column_of_cell_, row);
    case Form::json_lines:
      return parse_json_row(text, *kind_, row);
    case Form::in_order:
      return parse_cells(text, *kind_, columns_in_order(text, *kind_), row);
  }
}

bool RowReader::next(TargetRows& rows) {
  rows.column_count = kind_->columns.size();
  rows.values.clear();
  rows.lines.clear();
  if (!has_block_ && !source_.next(block_)) return false;
  if (!has_block_) used_ = 0;
  has_block_ = false;

  for (std::size_t i = used_; i < block_.size(); ++i) {
    if (!is_blank_line(block_.line(i))) rows.lines.push_back(block_.first_number + i);
  }
  rows.values.resize(rows.size() * rows.column_count);
  in_parallel(rows.size(), k_grain, [&](std::size_t i) {
    parse(line(static_cast<std::size_t>(rows.lines[i] - block_.first_number)),
          std::span(rows.values).subspan(i * rows.column_count, rows.column_count));
  });
  return true;
}

}  // namespace alidade::tools
