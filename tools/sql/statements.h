// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "database/sqlite/connection.h"

namespace alidade::tools {

/// How rows are printed. Real numbers have as many digits as distinguish them from every other one, and
/// always a dot or an exponent.
enum class RowForm {
  table,  ///< for people: columns aligned by the first 1000 rows, numbers to the right; NULL, blobs as
          ///< x'00ff'
  csv,    ///< a header, then a row per line; NULL is an empty cell, a blob hexadecimal
  json    ///< an array of an object per row; NULL and what is not finite are null, a blob hexadecimal text
};

/// A value for a parameter of a statement. It is bound, and never part of the statement's text.
struct SqlParameter {
  using Value = std::variant<std::monostate, std::int64_t, double, std::string>;

  std::string name;  ///< without its sign; empty if it is bound by its position
  Value value;
  bool is_used = false;
};

/// "1.5", "name=value". A value is NULL, a decimal number as in SQL (blanks around it and a plus are
/// ignored), 'text' with quotes in it written twice, or else text without quotes. Errors: text without quotes
/// that begins like a number, with a digit, dot or sign.
SqlParameter parse_sql_parameter(const std::string& text);

/// The text of a file; "-" is standard input. Errors: it cannot be read; it has a NUL byte.
std::string read_sql(const std::filesystem::path& file);

struct SqlRun {
  RowForm form = RowForm::table;
  bool explain = false;  ///< after the rows of each statement, print what was read, and whether it was pruned
  std::vector<SqlParameter> parameters{};
  bool are_all_used = true;  ///< whether a parameter that no statement has is an error
};

/// Runs all statements of a text and prints their rows; runs none if one of them is invalid. `file`: the name
/// of the text in messages. Conditions on dist_ray and dist_plane leave chunks unread
/// (database/sqlite/prepare.h). Errors: a statement that is not read-only, has a parameter without value, or
/// is invalid for SQLite; a parameter that no statement has; SQLite's. Cancelled, also while it waits for
/// another process that writes.
void run_statements(const database::Connection& connection, const std::string& text, const std::string& file,
                    SqlRun run);

}  // namespace alidade::tools
