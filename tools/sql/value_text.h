// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "database/sqlite/sqlite_api.h"

namespace alidade {

/// The shortest text that reads as this number again: 1.0, 0.1, 1e+300, inf.
std::string real_text(double value);

/// The value of a column as it is, without quotes: a blob hexadecimal, nothing for NULL.
std::string value_text(sqlite3_stmt* statement, int column);

/// Between quotes, for JSON. Bytes that are no UTF-8 become U+FFFD.
std::string json_text(std::string_view text);

/// As one line that cannot move a terminal's cursor: control characters are shown as \n, \x1b,
/// \u009b, bytes that are no UTF-8 as \xff, and letters that turn the direction of writing as \u202e.
std::string line_text(std::string_view text);

/// How many letters a text of UTF-8 has.
std::size_t letter_count(std::string_view text);

}  // namespace alidade
