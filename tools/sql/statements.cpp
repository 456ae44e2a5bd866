// SPDX-License-Identifier: MIT
#include "tools/sql/statements.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/shown_text.h"
#include "base/words.h"
#include "database/sqlite/prepare.h"
#include "database/sqlite/sql_tokens.h"
#include "database/sqlite/sqlite_api.h"
#include "tools/console.h"

namespace alidade::tools {
namespace {

bool is_name(std::string_view text) {
  const auto is_letter = [](char character) {
    return (character >= 'a' && character <= 'z') || (character >= 'A' && character <= 'Z') ||
           character == '_';
  };
  return !text.empty() && is_letter(text.front()) && std::ranges::all_of(text, [&](char character) {
    return is_letter(character) || (character >= '0' && character <= '9');
  });
}

/// A number as in SQL: blanks around it and a plus are allowed.
std::optional<SqlParameter::Value> sql_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  // Other words for numbers, such as inf and nan, are text in SQL.
  const std::string_view unsigned_text = text.substr(text.starts_with('-') ? 1 : 0);
  if (unsigned_text.find_first_of(".0123456789") != 0) return std::nullopt;
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  std::int64_t integer = 0;
  if (const auto [stop, error] = std::from_chars(begin, end, integer); stop == end && error == std::errc())
    return integer;
  double real = 0;
  const auto [stop, error] = std::from_chars(begin, end, real);
  if (stop != end) return std::nullopt;
  // In SQL, numbers too large for a double are infinite, and numbers too small are zero.
  return error == std::errc() ? real : std::strtod(std::string(text).c_str(), nullptr);
}

SqlParameter::Value sql_value(std::string_view text) {
  if (text == "NULL" || text == "null") return {};
  constexpr const char* k_blanks = " \t\n\v\f\r";
  const std::size_t first = text.find_first_not_of(k_blanks);
  if (first != std::string_view::npos) {
    const std::string_view word = text.substr(first, text.find_last_not_of(k_blanks) + 1 - first);
    if (std::optional<SqlParameter::Value> value = sql_number(word)) return std::move(*value);
    // As text it would compare greater than every number.
    if (std::string_view("0123456789.+-").find(word.front()) != std::string_view::npos)
      throw file_error("--param", "invalid number", "a number, or quoted text: \"'TEXT'\"",
                       std::string(text));
  }
  if (text.size() < 2 || text.front() != '\'' || text.back() != '\'') return std::string(text);
  std::string inner;
  text = text.substr(1, text.size() - 2);
  for (std::size_t i = 0; i < text.size(); ++i) {
    inner += text[i];
    if (text.substr(i).starts_with("''")) ++i;
  }
  return inner;
}

void bind(sqlite3_stmt* statement, int index, SqlParameter& parameter) {
  parameter.is_used = true;
  int result = SQLITE_OK;
  if (const auto* const integer = std::get_if<std::int64_t>(&parameter.value)) {
    result = sqlite3_bind_int64(statement, index, *integer);
  } else if (const auto* const real = std::get_if<double>(&parameter.value)) {
    result = sqlite3_bind_double(statement, index, *real);
  } else if (const auto* const text = std::get_if<std::string>(&parameter.value)) {
    result = sqlite3_bind_text64(statement, index, text->data(), text->size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  }
  if (result != SQLITE_OK) throw file_error("--param", sqlite3_errstr(result));
}

/// Gives all parameters of a statement their values: ? those without a name in their order, ?2 the second one
/// of these, :name, @name and $name those of that name. Errors: one has no value.
void bind_parameters(sqlite3_stmt* statement, std::vector<SqlParameter>& parameters) {
  int named = 0;
  for (int index = 1; index <= sqlite3_bind_parameter_count(statement); ++index) {
    const char* const sign_and_name = sqlite3_bind_parameter_name(statement, index);
    const bool is_numbered = sign_and_name != nullptr && *sign_and_name == '?';
    const std::string name = sign_and_name == nullptr || is_numbered ? "" : sign_and_name + 1;
    if (!name.empty()) ++named;
    // SQLite's indices also count parameters with names; ?2 is the second one in any case.
    const int wanted = is_numbered ? index : index - named;
    int unnamed_before = 0;
    const auto found = std::ranges::find_if(parameters, [&](const SqlParameter& parameter) {
      return parameter.name == name && (!name.empty() || ++unnamed_before == wanted);
    });
    if (found == parameters.end()) {
      throw input_error(
          name.empty() ? fmt::format("missing value of parameter {}", wanted)
                       : fmt::format("missing value of parameter {}", sign_and_name),
          name.empty() ? "--param VALUE for each, in order" : fmt::format("--param {}=VALUE", name));
    }
    bind(statement, index, *found);
  }
}

[[noreturn]] void reject_writing(const std::string& file, std::string location, std::string found) {
  throw Error({.file = file,
               .location = std::move(location),
               .problem = "the statement is not read-only",
               .expected = "SELECT, WITH, VALUES or EXPLAIN",
               .found = std::move(found)});
}

/// All statements of the text, with values for their parameters.
std::vector<database::Prepared> prepare_all(sqlite3* database, const std::string& text,
                                            const std::string& file, std::vector<SqlParameter>& parameters) {
  std::vector<database::Prepared> statements;
  const database::TokenList tokens(text);
  std::size_t end = 0;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    if (tokens[i].begin < end || tokens.is_sign(i, ";")) continue;
    const std::size_t begin = tokens[i].begin;
    // Some statements that write do so beside the database, which is open for reading only.
    if (!tokens.is_one_of(i, {"select", "with", "values", "explain"}))
      reject_writing(file, database::text_location(text, begin), std::string(tokens.text(i)));
    statements.push_back(database::prepare(database, text, begin, file));
    sqlite3_stmt* const statement = statements.back().statement.get();
    if (sqlite3_stmt_readonly(statement) == 0)
      reject_writing(file, database::text_location(text, begin), "a statement that writes");
    end = begin + statements.back().size;
    bind_parameters(statement, parameters);
  }
  return statements;
}

void reject_unused(const std::vector<SqlParameter>& parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].is_used) continue;
    throw file_error("--param", parameters[i].name.empty()
                                    ? fmt::format("no parameter for value {}", i + 1)
                                    : fmt::format("unknown parameter :{}", parameters[i].name));
  }
}

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

/// Prints the rows of one statement on stdout, some at a time.
class RowWriter {
 public:
  virtual ~RowWriter() = default;

  virtual void begin(const std::vector<std::string>& columns) = 0;
  /// Adds the current row of the statement.
  virtual void row(sqlite3_stmt* statement) = 0;
  virtual void end() = 0;
};

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

std::unique_ptr<RowWriter> make_row_writer(RowForm form) {
  if (form == RowForm::csv) return std::make_unique<CsvWriter>();
  if (form == RowForm::json) return std::make_unique<JsonWriter>();
  return std::make_unique<TableWriter>();
}

std::string share(std::uint64_t part, std::uint64_t all) {
  return all == 0 ? ""
                  : fmt::format(" ({:.1f} %)", 100.0 * static_cast<double>(part) / static_cast<double>(all));
}

/// A statement keeps its lines: they are the user's own.
void say_rewritten(std::string_view statement) {
  std::string text = "alidade: rewritten as: ";
  for (std::size_t begin = 0; begin <= statement.size();) {
    const std::size_t end = std::min(statement.find('\n', begin), statement.size());
    text += line_text(statement.substr(begin, end - begin)) + "\n";
    begin = end + 1;
  }
  write_to_stderr(text);
}

void explain(const database::Prepared& prepared, const database::ScanReads& before,
             const database::ScanReads& after, std::uint64_t rows, double milliseconds) {
  const std::uint64_t scans = after.scans - before.scans, chunks = after.chunks - before.chunks,
                      read = after.chunks_read - before.chunks_read;
  std::string text =
      scans == 0 ? "read no cloud" : fmt::format("read {} of {} chunks{}", read, chunks, share(read, chunks));
  if (scans > 1) text += fmt::format(" in {} scans", scans);
  if (scans > 0) text += fmt::format(", {} points tested", after.points_read - before.points_read);
  say_note(fmt::format("{}, {} {}, {:.1f} ms", text, rows, rows == 1 ? "row" : "rows", milliseconds));
  if (!prepared.pruned.empty()) say_rewritten(prepared.pruned);
  if (!prepared.reason.empty())
    say_note((prepared.pruned.empty() ? "not rewritten: " : "not rewritten further: ") + prepared.reason);
}

void run_one(const database::Connection& connection, database::Prepared& prepared, const SqlRun& run) {
  const auto start = std::chrono::steady_clock::now();
  const database::ScanReads before = connection.reads();
  sqlite3_stmt* const statement = prepared.statement.get();
  std::vector<std::string> columns;
  const int count = sqlite3_column_count(statement);
  columns.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) columns.emplace_back(sqlite3_column_name(statement, i));
  const std::unique_ptr<RowWriter> writer = make_row_writer(run.form);
  writer->begin(columns);
  std::uint64_t rows = 0;
  int result = SQLITE_ROW;
  while ((result = sqlite3_step(statement)) == SQLITE_ROW) {
    writer->row(statement);
    ++rows;
  }
  if (result == SQLITE_INTERRUPT) throw Cancelled();
  if (result != SQLITE_DONE)
    throw file_error(database::file_of(connection.get()), sqlite3_errmsg(connection.get()));
  writer->end();
  prepared.statement.reset();
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
  if (run.explain) explain(prepared, before, connection.reads(), rows, taken.count());
}

}  // namespace

SqlParameter parse_sql_parameter(const std::string& text) {
  SqlParameter parameter;
  std::string_view value = text;
  const std::size_t equals = value.find('=');
  if (equals != std::string_view::npos && is_name(value.substr(0, equals))) {
    parameter.name = value.substr(0, equals);
    value.remove_prefix(equals + 1);
  }
  parameter.value = sql_value(value);
  return parameter;
}

std::string read_sql(const std::filesystem::path& file) {
  if (file != "-" && std::filesystem::is_directory(file))
    throw Error({.file = file.string(), .problem = "cannot read the file", .found = "a folder"});
  std::ifstream opened;
  if (file != "-") opened.open(file, std::ios::binary);
  // /dev/stdin cannot be opened where standard input is a socket, as Node makes it for its children.
  std::istream& stream = file == "-" ? std::cin : opened;
  std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream) throw file_error(file, "cannot read the file");
  if (const std::size_t nul = text.find('\0'); nul != std::string::npos) {
    throw Error({.file = file.string(),
                 .location = database::text_location(text, nul),
                 .problem = "the file contains a NUL byte",
                 .found = "0"});
  }
  return text;
}

void run_statements(const database::Connection& connection, const std::string& text, const std::string& file,
                    SqlRun run) {
  constexpr int k_steps = 1000;
  sqlite3_progress_handler(
      connection.get(), k_steps, [](void*) { return interrupted() ? 1 : 0; }, nullptr);
  try {
    std::vector<database::Prepared> statements = prepare_all(connection.get(), text, file, run.parameters);
    if (run.are_all_used) reject_unused(run.parameters);
    for (database::Prepared& prepared : statements) run_one(connection, prepared, run);
  } catch (const Error&) {
    // An interrupted wait for a lock ends as an error of the locked file.
    if (interrupted()) throw Cancelled();
    throw;
  }
}

}  // namespace alidade::tools
