// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace alidade::database {

/// `text` between two marks, with marks within it doubled, so that it cannot end early.
inline std::string sql_quoted(std::string_view text, char mark) {
  std::string quoted(1, mark);
  for (const char character : text) quoted.append(character == mark ? 2 : 1, character);
  return quoted + mark;
}

/// `name` as a name in SQL, whatever its characters: "na""me".
inline std::string sql_name(std::string_view name) {
  return sql_quoted(name, '"');
}

/// `text` as a literal in SQL: 'te''xt'.
inline std::string sql_text(std::string_view text) {
  return sql_quoted(text, '\'');
}

}  // namespace alidade::database
