// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

// Text for people.
//
// Escaping of text that comes from files: names of attributes, files, cameras and reference systems may hold
// anything. One function for each destination.
//
// Characters that a terminal, an editor or a page obeys instead of showing them are written as escapes
// everywhere: control characters of ASCII and of C1, line separators, and those that turn the direction of
// writing.

namespace alidade {

/// For a line on a terminal and in messages: `\n`, `\x1b`, `\u009b`, `\u202e`; bytes that are not UTF-8 as
/// `\xff`. Applied again, it changes nothing.
std::string line_text(std::string_view text);

/// A cell of CSV that is text: line_text(), after an apostrophe if spreadsheets would take it for a formula
/// (=, +, -, @ in front, unless it is a number), in quotes if it needs them (RFC 4180) or has a semicolon.
std::string csv_cell(std::string_view text);

/// Equivalent JSON in which strings hold such characters as `\u009b`, `\u202e`.
std::string plain_json(std::string json);

/// The text of a value of nlohmann::json; bytes that are not UTF-8 become U+FFFD.
template <class Json>
std::string json_text(const Json& json, int indent = -1) {
  return plain_json(json.dump(indent, ' ', false, Json::error_handler_t::replace));
}

/// "1.25 M", "340 k", "12": a count for people to read.
std::string short_count(double count);

/// "640 k points", "1 ray", "2.3 MB": a count of a unit, which is "B" or a plural.
std::string quantity(double count, const std::string& unit);

/// "0:07", "12:30", "1:02:03".
std::string clock_time(double seconds);

}  // namespace alidade
