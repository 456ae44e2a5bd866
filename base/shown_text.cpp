// SPDX-License-Identifier: MIT
#include "base/shown_text.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/words.h"

namespace alidade {
namespace {

/// The code point of one character of UTF-8.
unsigned character_code(std::string_view character) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(character[i]); };
  if (character.size() == 1) return byte(0);
  unsigned code = byte(0) & (0x7fu >> character.size());
  for (std::size_t i = 1; i < character.size(); ++i) code = code << 6 | (byte(i) & 0x3fu);
  return code;
}

/// Whether a terminal obeys a character beyond ASCII instead of showing it: C1, line separators, and the
/// direction of writing.
bool is_command(unsigned code) {
  return (code >= 0x80 && code <= 0x9f) || code == 0x061c || code == 0x200e || code == 0x200f ||
         (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

/// Calls use(character, code) for each character of UTF-8; NUL and a byte that begins none are without code.
template <class Use>
void for_each_character(std::string_view text, const Use& use) {
  while (!text.empty()) {
    const std::size_t size = utf8_character_size(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(size, 1));
    text.remove_prefix(character.size());
    use(character, size > 0 ? std::optional(character_code(character)) : std::nullopt);
  }
}

}  // namespace

std::string line_text(std::string_view text) {
  std::string line;
  for_each_character(text, [&](std::string_view character, std::optional<unsigned> code) {
    if (code == unsigned{'\n'})
      line += "\\n";
    else if (!code || *code < 0x20 || *code == 0x7f)
      line += fmt::format("\\x{:02x}", static_cast<unsigned char>(character.front()));
    else if (is_command(*code))
      line += fmt::format("\\u{:04x}", *code);
    else
      line += character;
  });
  return line;
}

std::string csv_cell(std::string_view text) {
  std::string shown = line_text(text);
  const bool is_formula = !shown.empty() &&
                          std::string_view("=+-@").find(shown.front()) != std::string_view::npos &&
                          !parse_number(shown);
  if (is_formula) shown.insert(0, 1, '\'');
  if (shown.find_first_of(",;\"") == std::string::npos) return shown;
  std::string cell = "\"";
  for (const char character : shown) cell.append(character == '"' ? 2 : 1, character);
  return cell + '"';
}

std::string plain_json(std::string json) {
  // These are only in strings: JSON is ASCII outside of them, and has escapes for its control characters in
  // them.
  if (std::ranges::all_of(json, [](char byte) { return static_cast<unsigned char>(byte) < 0x7f; }))
    return json;
  std::string plain;
  for_each_character(json, [&](std::string_view character, std::optional<unsigned> code) {
    if (code && (*code == 0x7f || is_command(*code)))
      plain += fmt::format("\\u{:04x}", *code);
    else
      plain += character;
  });
  return plain;
}

std::string short_count(double count) {
  if (count >= 999.5e6) return fmt::format("{:.3g} G", count / 1e9);
  if (count >= 999.5e3) return fmt::format("{:.3g} M", count / 1e6);
  if (count >= 1e4) return fmt::format("{:.3g} k", count / 1e3);
  return fmt::format("{:.0f}", count);
}

std::string quantity(double count, const std::string& unit) {
  const std::string text = short_count(count);
  // "2.3 MB", but "2.3 M points".
  if (unit == "B") return text.find(' ') == std::string::npos ? text + " B" : text + unit;
  if (text != "1" || !unit.ends_with('s')) return text + " " + unit;
  return text + " " + unit.substr(0, unit.size() - (unit.ends_with("xes") ? 2 : 1));
}

std::string clock_time(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::fmin(std::fmax(std::round(seconds), 0.0), 1e12));
  const std::int64_t hours = whole / 3600, minutes = whole / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, whole % 60);
  return fmt::format("{}:{:02}", minutes, whole % 60);
}

}  // namespace alidade
