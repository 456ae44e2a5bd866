// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "database/sqlite/sqlite_api.h"

namespace alidade {

/// A value for a parameter of a statement. It is bound, and never part of the statement's text.
struct SqlParameter {
  using Value = std::variant<std::monostate, std::int64_t, double, std::string>;

  std::string name;  ///< without its sign; empty if it is bound by its place
  Value value;
  bool is_used = false;
};

/// "1.5", "name=value". A value is NULL, a decimal number as in SQL (blanks around it and a plus do not
/// matter), 'text' with quotes in it written twice, or else text as it stands. Errors: text without quotes
/// that begins like a number, with a digit, dot or sign.
SqlParameter parse_sql_parameter(const std::string& text);

/// Gives all parameters of a statement their values: ? those without a name in their order, ?2 the second one
/// of these, :name,
/// @name and $name those of that name. Errors: one has no value.
void bind_parameters(sqlite3_stmt* statement, std::vector<SqlParameter>& parameters);

}  // namespace alidade
