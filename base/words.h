// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace alidade {

/// Bytes of the character that a text begins with: UTF-8 in its shortest form, without surrogates of UTF-16
/// and NUL. 0 if it begins with none.
std::size_t utf8_character_size(std::string_view text);

/// Whether a byte is within a character of UTF-8, not its first.
inline bool is_continuation(char byte) {
  return (static_cast<unsigned char>(byte) & 0xc0) == 0x80;
}

/// How many characters a text of UTF-8 has.
inline std::size_t character_count(std::string_view text) {
  return text.size() - static_cast<std::size_t>(std::ranges::count_if(text, is_continuation));
}

/// Whether a text consists of characters that utf8_character_size() accepts.
bool is_utf8(std::string_view text);

/// A text with the capitals of ASCII in lower case.
inline std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& character : lower) {
    if (character >= 'A' && character <= 'Z') character = static_cast<char>(character - 'A' + 'a');
  }
  return lower;
}

/// The extension of a file's name in lower case: ".csv" of "A.CSV".
inline std::string file_extension(const std::filesystem::path& file) {
  return lower_case(file.extension().string());
}

/// Whether a file's name has one of these extensions, given in lower case; the name's own case is ignored.
inline bool has_extension(const std::filesystem::path& file,
                          std::initializer_list<std::string_view> extensions) {
  return std::ranges::find(extensions, file_extension(file)) != extensions.end();
}

/// UTF-8 for U+FEFF, which some programs put before a text.
inline constexpr std::string_view k_byte_order_mark = "\xEF\xBB\xBF";

/// Blank, tab or carriage return.
inline bool is_blank(char character) {
  return character == ' ' || character == '\t' || character == '\r';
}

/// The text without is_blank() characters at its ends.
std::string_view trim(std::string_view text);

/// The number that a whole word denotes: decimal or scientific, with an optional sign, "nan", "inf"; empty if
/// it is not a number. Never depends on the locale. Too large a number is infinite, too small a one is zero.
std::optional<double> parse_number(std::string_view word);

/// As parse_number() for whole numbers without exponent; empty also if the number does not fit.
template <class Whole = std::uint64_t>
std::optional<Whole> parse_count(std::string_view word) {
  Whole value = 0;
  const char* const end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, value);
  if (result.ptr != end || result.ec != std::errc{}) return std::nullopt;
  return value;
}

/// `word` as POSIX shells and fish read it: as it is if it has only letters and digits of ASCII and any of
/// _-.:/,+@ (and is not empty), else in quotes.
std::string shell_word(std::string_view word);

/// Text of a URL with its %XX replaced; empty if one is no code of a character, or means NUL.
std::optional<std::string> percent_decoded(std::string_view text);

/// How many digits after the decimal point a number is written with: 2 for "1.25", 4 for "1.25e-2", 0 for
/// "12", -3 for "1e3".
int written_decimals(std::string_view word);

/// Splits a line at blanks, tabs and carriage returns.
void split_words(std::string_view line, std::vector<std::string_view>& words);

/// Splits a line at `separator`, and removes blanks and double quotes around the words. Between double quotes
/// a separator is part of the word, and a quote that is written twice stays so.
void split_cells(std::string_view line, char separator, std::vector<std::string_view>& words);

/// Text of a file as an error message shows it: line_text() (base/shown_text.h) in quotes, cut after 40
/// bytes.
std::string quote(std::string_view text);

/// The word of `words` that was probably meant, by edit distance (swapped letters count once); empty if none
/// is near.
std::string_view nearest_word(std::string_view word, std::span<const std::string_view> words);

}  // namespace alidade
