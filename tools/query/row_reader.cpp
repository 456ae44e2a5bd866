// SPDX-License-Identifier: MIT
#include "tools/query/row_reader.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <atomic>

#include "base/error.h"
#include "base/text_scanner.h"
#include "tools/query/parse_cells.h"
#include "tools/query/parse_json_row.h"

namespace alidade {
namespace {

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
               .place = source_.is_command_line() ? "" : fmt::format("{}:1", number),
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
    const char letter = trim(first.text).front();
    form_ = letter == '{' || letter == '[' ? Form::json_lines : Form::csv;
    if (form_ == Form::csv) {
      column_of_cell_ = read_header(first, *kind_);
      ++used_;
    }
    return;
  }
  throw Error({.file = source_.name(),
               .place = source_.is_command_line() ? "" : "1:1",
               .problem = fmt::format("holds no {}", kind_->plural),
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
  const auto parse_row = [&](std::size_t i) {
    parse(line(static_cast<std::size_t>(rows.lines[i] - block_.first_number)),
          std::span(rows.values).subspan(i * rows.column_count, rows.column_count));
  };
  // The first bad line is told, whatever the threads met before.
  std::atomic<std::size_t> first_bad{rows.size()};
  tbb::parallel_for(std::size_t{0}, (rows.size() + k_grain - 1) / k_grain, [&](std::size_t part) {
    for (std::size_t i = part * k_grain; i < std::min((part + 1) * k_grain, rows.size()); ++i) {
      try {
        parse_row(i);
      } catch (const Error&) {
        std::size_t known = first_bad;
        while (i < known && !first_bad.compare_exchange_weak(known, i)) {
        }
        return;
      }
    }
  });
  if (first_bad < rows.size()) parse_row(first_bad);
  return true;
}

}  // namespace alidade
