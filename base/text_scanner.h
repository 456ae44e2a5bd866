// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "cloud/point_table.h"

namespace alidade {

/// Walks through the lines of a text file, or of the text part of a mixed one, without copying them.
/// Lines end with "\n" or "\r\n"; the last one may lack its end. A byte order mark at the start of the file
/// is skipped. Memory: one window of a mebibyte; a longer line is an Error.
class TextScanner {
 public:
  /// Starts at byte `place`, which is the start of the line after number `line_number`.
  explicit TextScanner(InputFile& file, std::uint64_t place = 0, std::uint64_t line_number = 0);

  /// The next line without its end, valid until the next call; empty optional at the end of the file.
  std::optional<std::string_view> next_line();

  /// Fills `words` from the next line that is not blank; they are valid until the next call. False at the end
  /// of the file.
  bool next_words(std::vector<std::string_view>& words);

  /// Number of the line last given, from 1.
  std::uint64_t line_number() const { return line_number_; }
  /// Byte after the line last given, its end included.
  std::uint64_t place() const { return window_place_ + used_; }

  /// Throws the Error for the line last given.
  [[noreturn]] void fail(std::string problem, std::string expected = {}, std::string found = {}) const;

 private:
  InputFile& file_;
  std::uint64_t window_place_;
  std::string_view window_;
  std::size_t used_ = 0;  ///< bytes of the window already given out
  std::uint64_t line_number_;
};

/// Most columns of a point table: far beyond any real file, so that a header of nothing but columns is
/// refused before anything is done for each of them.
inline constexpr std::size_t k_most_columns = 4096;

/// Errors: a table with more than k_most_columns, said of the line last given.
void require_few_columns(const TextScanner& scanner, std::size_t count);

/// UTF-8 for U+FEFF, which some programs put before a text.
inline constexpr std::string_view k_byte_order_mark = "\xEF\xBB\xBF";

/// Blank, tab or carriage return.
bool is_blank(char letter);

/// The text without is_blank() letters at its ends.
std::string_view trim(std::string_view text);

/// The number a whole word stands for: decimal or scientific, with an optional sign, "nan", "inf"; empty if
/// it is none. Never depends on the locale. Too large a number is infinite, too small a one is zero.
std::optional<double> parse_number(std::string_view word);

/// The same for whole numbers without exponent; empty also if it does not fit.
std::optional<std::uint64_t> parse_count(std::string_view word);

/// How many digits after the decimal point a number is written with: 2 for "1.25", 4 for "1.25e-2", 0 for
/// "12", -3 for "1e3".
int written_decimals(std::string_view word);

/// Fills `words` with what stands between blanks, tabs and carriage returns.
void split_words(std::string_view line, std::vector<std::string_view>& words);

/// Fills `words` with what stands between `separator`s, without blanks and double quotes around it; between
/// double quotes a separator is part of the word.
void split_cells(std::string_view line, char separator, std::vector<std::string_view>& words);

/// The cell for a word of the line last given. Errors: the word is no number, or, for the 64-bit types, no
/// whole number that fits.
Cell require_cell(const TextScanner& scanner, std::string_view word, ScalarType type);

/// Text of a file as an error message can show it: in quotes, unprintable bytes as "?", cut after 40 bytes.
std::string quote(std::string_view text);

}  // namespace alidade
