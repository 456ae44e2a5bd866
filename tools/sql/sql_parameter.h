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
  std::string name;  ///< without its sign; empty if it is bound by its place
  std::variant<std::monostate, std::int64_t, double, std::string> value;
  bool is_used = false;
};

/// "1.5", "name=value". A value is NULL, a number, 'text', or else text as it stands.
SqlParameter parse_sql_parameter(const std::string& text);

/// Gives all parameters of a statement their values: ?, ?1 and ?2 those without a name in their order, :name,
/// @name and $name those of that name. Errors: one has no value.
void bind_parameters(sqlite3_stmt* statement, std::vector<SqlParameter>& parameters);

}  // namespace alidade
