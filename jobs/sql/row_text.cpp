// SPDX-License-Identifier: MIT
#include "jobs/sql/row_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/shown_text.h"
#include "base/words.h"

namespace alidade::jobs {
namespace {

constexpr std::uint64_t k_measured_rows = 1000;

/// Digits of a real number, with a point where they look like a whole one: 1.0, 0.1, 1e+300, inf.
std::string real_text(std::string digits) {
  if (digits.find_first_not_of("-0123456789") == std::string::npos) digits += ".0";
  return digits;
}

bool is_text(const SqlValue& value) {
  return std::holds_alternative<std::string>(value);
}

bool is_bytes(const SqlValue& value) {
  return std::holds_alternative<std::vector<std::byte>>(value);
}

/// A value as it is, without quotes: bytes hexadecimal, nothing for NULL.
std::string plain_text(const SqlValue& value) {
  if (const auto* const whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
  if (const auto* const real = std::get_if<double>(&value)) return real_text(fmt::format("{}", *real));
  if (is_text(value)) return std::get<std::string>(value);
  std::string text;
  if (is_bytes(value))
    for (const std::byte byte : std::get<std::vector<std::byte>>(value))
      text += fmt::format("{:02x}", static_cast<unsigned>(byte));
  return text;
}

std::string csv_text(const SqlValue& value) {
  const std::string text = plain_text(value);
  return !is_text(value) ? text : text.empty() ? "\"\"" : csv_cell(text);
}

std::string json_text_of(const SqlValue& value) {
  const auto* const real = std::get_if<double>(&value);
  if (value.index() == 0 || (real != nullptr && !std::isfinite(*real))) return "null";
  const std::string text = plain_text(value);
  return is_text(value) || is_bytes(value) ? json_text(nlohmann::json(text)) : text;
}

std::string table_text(const SqlValue& value) {
  // The last two digits of lattice coordinates are rounding errors, as in 428.15000000000003.
  if (const auto* const real = std::get_if<double>(&value)) return real_text(fmt::format("{:.15g}", *real));
  if (value.index() == 0) return "NULL";
  const std::string text = line_text(plain_text(value));
  return is_bytes(value) ? fmt::format("x'{}'", text) : text;
}

/// Makes text of rows.
class RowText {
 public:
  RowText(SqlForm form, std::function<void(std::string_view)> write)
      : form_(form), write_(std::move(write)) {}

  void begin(const std::vector<std::string>& columns) {
    rows_ = 0;
    columns_.clear();
    widths_.clear();
    is_right_.assign(columns.size(), true);
    for (const std::string& column : columns) {
      columns_.push_back(form_ == SqlForm::csv    ? csv_cell(column)
                         : form_ == SqlForm::json ? json_text(nlohmann::json(column)) + ":"
                                                  : line_text(column));
      widths_.push_back(character_count(columns_.back()));
    }
    if (form_ == SqlForm::csv) text_ += fmt::format("{}\n", fmt::join(columns_, ","));
    if (form_ == SqlForm::json) text_ += "[";
  }

  void row(std::span<const SqlValue> values) {
    constexpr std::size_t k_enough = 1u << 16;
    const auto add_cells = [&](std::string (*cell)(const SqlValue&)) {
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (i > 0) text_ += ",";
        if (form_ == SqlForm::json) text_ += columns_[i];
        text_ += cell(values[i]);
      }
    };
    if (form_ == SqlForm::table) {
      add_table_row(values);
    } else if (form_ == SqlForm::csv) {
      add_cells(csv_text);
      text_ += "\n";
    } else {
      text_ += rows_ == 0 ? "{" : ",\n{";
      add_cells(json_text_of);
      text_ += "}";
    }
    ++rows_;
    if (text_.size() >= k_enough) hand_on();
  }

  void end() {
    if (form_ == SqlForm::json) text_ += "]\n";
    if (form_ == SqlForm::table && rows_ < k_measured_rows) add_waiting();
    hand_on();
  }

 private:
  void add_table_row(std::span<const SqlValue> values) {
    std::vector<std::string> cells(values.size());
    std::ranges::transform(values, cells.begin(), table_text);
    if (rows_ >= k_measured_rows) return add_table_line(cells);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      widths_[i] = std::max(widths_[i], character_count(cells[i]));
      if (is_text(values[i]) || is_bytes(values[i])) is_right_[i] = false;
    }
    waiting_.push_back(std::move(cells));
    if (waiting_.size() == k_measured_rows) add_waiting();
  }

  void add_waiting() {
    add_table_line(columns_);
    std::vector<std::string> rules;
    for (const std::size_t width : widths_) rules.emplace_back(width, '-');
    add_table_line(rules);
    for (const std::vector<std::string>& cells : waiting_) add_table_line(cells);
    waiting_.clear();
  }

  void add_table_line(const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::size_t width = character_count(cells[i]);
      const std::string blanks(std::max(widths_[i], width) - width, ' ');
      text_ += i > 0 ? "  " : "";
      if (is_right_[i]) text_ += blanks;
      text_ += cells[i];
      if (!is_right_[i] && i + 1 < cells.size()) text_ += blanks;
    }
    text_ += "\n";
  }

  void hand_on() {
    write_(text_);
    text_.clear();
  }

  SqlForm form_;
  std::function<void(std::string_view)> write_;
  std::string text_;
  std::uint64_t rows_ = 0;
  std::vector<std::string> columns_;
  // Of a table:
  std::vector<std::size_t> widths_;
  std::vector<bool> is_right_;                     ///< columns without text
  std::vector<std::vector<std::string>> waiting_;  ///< until the widths are known
};

}  // namespace

RowSink row_text(SqlForm form, std::function<void(std::string_view)> write) {
  const auto text = std::make_shared<RowText>(form, std::move(write));
  return {.begin = [text](const std::vector<std::string>& columns) { text->begin(columns); },
          .row = [text](std::span<const SqlValue> values) { text->row(values); },
          .end = [text](const StatementReport&) { text->end(); }};
}

}  // namespace alidade::jobs
