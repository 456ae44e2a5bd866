// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/shown_text.h"
#include "base/words.h"
#include "database/sqlite/sqlite_api.h"
#include "tools/console.h"
#include "tools/sql/statements.h"

namespace alidade::tools {
namespace {

/// Digits of a real number, with a point where they look like a whole one: 1.0, 0.1, 1e+300, inf.
std::string real_text(std::string digits) {
  if (digits.find_first_not_of("-0123456789") == std::string::npos) digits += ".0";
  return digits;
}

/// The value of a column as it is, without quotes: a blob hexadecimal, nothing for NULL.
std::string value_text(sqlite3_stmt* statement, int column) {
  const auto size = [&] { return static_cast<std::size_t>(sqlite3_column_bytes(statement, column)); };
  switch (sqlite3_column_type(statement, column)) {
    case SQLITE_INTEGER:
      return std::to_string(sqlite3_column_int64(statement, column));
    case SQLITE_FLOAT:
      return real_text(fmt::format("{}", sqlite3_column_double(statement, column)));
    case SQLITE_TEXT: {
      const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
      return text == nullptr ? std::string() : std::string(text, size());
    }
    case SQLITE_BLOB: {
      const auto* const bytes = static_cast<const unsigned char*>(sqlite3_column_blob(statement, column));
      std::string text;
      for (std::size_t i = 0; i < size(); ++i) text += fmt::format("{:02x}", bytes[i]);
      return text;
    }
    default:
      return {};
  }
}

/// Collects text for stdout, so that not every row is a system call.
class Output {
 public:
  Output& operator<<(std::string_view text) {
    text_ += text;
    return *this;
  }
  void end_row() {
    constexpr std::size_t k_enough = 1u << 16;
    if (text_.size() >= k_enough) flush();
  }
  void flush() {
    write_to_stdout(text_);
    text_.clear();
  }

 private:
  std::string text_;
};

class CsvWriter : public RowWriter {
 public:
  void begin(const std::vector<std::string>& columns) override {
    for (std::size_t i = 0; i < columns.size(); ++i) out_ << (i > 0 ? "," : "") << csv_cell(columns[i]);
    out_ << "\n";
  }
  void row(sqlite3_stmt* statement) override {
    const int count = sqlite3_column_count(statement);
    for (int i = 0; i < count; ++i) {
      const bool is_text = sqlite3_column_type(statement, i) == SQLITE_TEXT;
      const std::string text = value_text(statement, i);
      out_ << (i > 0 ? "," : "") << (!is_text ? text : text.empty() ? "\"\"" : csv_cell(text));
    }
    out_ << "\n";
    out_.end_row();
  }
  void end() override { out_.flush(); }

 private:
  Output out_;
};

class JsonWriter : public RowWriter {
 public:
  void begin(const std::vector<std::string>& columns) override {
    for (const std::string& column : columns) keys_.push_back(json_text(nlohmann::json(column)) + ":");
    out_ << "[";
  }
  void row(sqlite3_stmt* statement) override {
    out_ << (is_first_ ? "{" : ",\n{");
    is_first_ = false;
    for (int i = 0; i < static_cast<int>(keys_.size()); ++i)
      out_ << (i > 0 ? "," : "") << keys_[static_cast<std::size_t>(i)] << value(statement, i);
    out_ << "}";
    out_.end_row();
  }
  void end() override {
    out_ << "]\n";
    out_.flush();
  }

 private:
  static std::string value(sqlite3_stmt* statement, int column) {
    const int type = sqlite3_column_type(statement, column);
    if (type == SQLITE_NULL) return "null";
    if (type == SQLITE_FLOAT && !std::isfinite(sqlite3_column_double(statement, column))) return "null";
    const std::string text = value_text(statement, column);
    return type == SQLITE_TEXT || type == SQLITE_BLOB ? json_text(nlohmann::json(text)) : text;
  }

  Output out_;
  std::vector<std::string> keys_;
  bool is_first_ = true;
};

class TableWriter : public RowWriter {
 public:
  void begin(const std::vector<std::string>& columns) override {
    for (const std::string& column : columns) {
      names_.push_back(line_text(column));
      widths_.push_back(character_count(names_.back()));
    }
    is_right_.resize(names_.size(), true);
  }
  void row(sqlite3_stmt* statement) override {
    constexpr std::size_t k_measured = 1000;
    std::vector<std::string> cells;
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const int column = static_cast<int>(i), type = sqlite3_column_type(statement, column);
      // The last two digits of lattice coordinates are rounding errors, as in 428.15000000000003.
      std::string text = type == SQLITE_FLOAT
                             ? real_text(fmt::format("{:.15g}", sqlite3_column_double(statement, column)))
                             : line_text(value_text(statement, column));
      if (type == SQLITE_NULL) text = "NULL";
      if (type == SQLITE_BLOB) text = fmt::format("x'{}'", text);
      if (!has_begun_) {
        widths_[i] = std::max(widths_[i], character_count(text));
        if (type == SQLITE_TEXT || type == SQLITE_BLOB) is_right_[i] = false;
      }
      cells.push_back(std::move(text));
    }
    if (has_begun_) {
      line(cells);
    } else {
      waiting_.push_back(std::move(cells));
      if (waiting_.size() == k_measured) print_waiting();
    }
  }
  void end() override {
    if (!has_begun_) print_waiting();
    out_.flush();
  }

 private:
  void print_waiting() {
    has_begun_ = true;
    line(names_);
    std::vector<std::string> rules;
    for (const std::size_t width : widths_) rules.emplace_back(width, '-');
    line(rules);
    for (const std::vector<std::string>& cells : waiting_) line(cells);
    waiting_.clear();
  }
  void line(const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::size_t width = character_count(cells[i]);
      const std::string blanks(std::max(widths_[i], width) - width, ' ');
      out_ << (i > 0 ? "  " : "");
      if (is_right_[i]) out_ << blanks;
      out_ << cells[i];
      if (!is_right_[i] && i + 1 < cells.size()) out_ << blanks;
    }
    out_ << "\n";
    out_.end_row();
  }

  Output out_;
  std::vector<std::string> names_;
  std::vector<std::size_t> widths_;
  std::vector<bool> is_right_;                     ///< columns without text
  std::vector<std::vector<std::string>> waiting_;  ///< until the widths are known
  bool has_begun_ = false;
};

}  // namespace

std::unique_ptr<RowWriter> make_row_writer(RowForm form) {
  if (form == RowForm::csv) return std::make_unique<CsvWriter>();
  if (form == RowForm::json) return std::make_unique<JsonWriter>();
  return std::make_unique<TableWriter>();
}

}  // namespace alidade::tools
