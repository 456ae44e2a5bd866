// SPDX-License-Identifier: MIT
#include "tools/sql/value_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/words.h"

namespace alidade {
namespace {

/// The code in Unicode of what is one letter of UTF-8.
unsigned letter_code(std::string_view letter) {
  const auto byte = [&](std::size_t place) { return static_cast<unsigned char>(letter[place]); };
  if (letter.size() == 1) return byte(0);
  unsigned code = byte(0) & (0x7fu >> letter.size());
  for (std::size_t place = 1; place < letter.size(); ++place) code = code << 6 | (byte(place) & 0x3fu);
  return code;
}

/// Whether terminals take a letter beyond ASCII as a command, or as one that turns the direction of writing.
bool is_command(unsigned code) {
  return (code >= 0x80 && code <= 0x9f) || (code >= 0x202a && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069);
}

}  // namespace

std::string real_text(double value) {
  std::string text = fmt::format("{}", value);
  if (std::isfinite(value) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string value_text(sqlite3_stmt* statement, int column) {
  const auto size = [&] { return static_cast<std::size_t>(sqlite3_column_bytes(statement, column)); };
  switch (sqlite3_column_type(statement, column)) {
    case SQLITE_INTEGER:
      return std::to_string(sqlite3_column_int64(statement, column));
    case SQLITE_FLOAT:
      return real_text(sqlite3_column_double(statement, column));
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

std::string json_text(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string line_text(std::string_view text) {
  std::string line;
  while (!text.empty()) {
    const std::size_t size = utf8_letter_size(text);
    const std::string_view letter = text.substr(0, std::max<std::size_t>(size, 1));
    text.remove_prefix(letter.size());
    const unsigned code = size == 0 ? static_cast<unsigned char>(letter.front()) : letter_code(letter);
    if (code == '\n')
      line += "\\n";
    else if (size == 0 || code < 0x20 || code == 0x7f)
      line += fmt::format("\\x{:02x}", code);
    else if (is_command(code))
      line += fmt::format("\\u{:04x}", code);
    else
      line += letter;
  }
  return line;
}

std::size_t letter_count(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char letter) { return (static_cast<unsigned char>(letter) & 0xc0u) != 0x80u; }));
}

}  // namespace alidade
