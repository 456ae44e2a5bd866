// SPDX-License-Identifier: MIT
#include "database/sqlite/sql_values.h"

#include <fmt/format.h>

#include "base/error.h"

namespace alidade {

template <std::size_t count>
std::optional<std::array<double, count>> numbers(std::span<sqlite3_value* const> values,
                                                 const char* function) {
  std::array<double, count> result{};
  bool is_null = false;
  for (std::size_t i = 0; i < count; ++i) {
    const int type = sqlite3_value_type(values[i]);
    if (type == SQLITE_NULL) {
      is_null = true;
    } else if (type == SQLITE_INTEGER || type == SQLITE_FLOAT) {
      result[i] = sqlite3_value_double(values[i]);
    } else {
      throw Error({.problem = fmt::format("{}: argument {} is no number", function, i + 1),
                   .expected = "a number or NULL",
                   .found = type == SQLITE_TEXT ? "text" : "a blob"});
    }
  }
  if (is_null) return std::nullopt;
  return result;
}

template std::optional<std::array<double, 6>> numbers<6>(std::span<sqlite3_value* const>, const char*);
template std::optional<std::array<double, 8>> numbers<8>(std::span<sqlite3_value* const>, const char*);
template std::optional<std::array<double, 9>> numbers<9>(std::span<sqlite3_value* const>, const char*);

}  // namespace alidade
