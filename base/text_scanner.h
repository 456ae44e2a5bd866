// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "base/words.h"

namespace alidade {

/// Walks through the lines of a text file, or of the text part of a mixed one, without copying them. Lines
/// end with "\n", "\r\n" or "\r"; the last one may lack its end. A byte order mark at the start of the file
/// is skipped. Memory: one window of a mebibyte. Errors: a longer line; UTF-16.
class TextScanner {
 public:
  /// Starts at byte `offset`, which is the start of the line after number `line_number`.
  explicit TextScanner(InputFile& file, std::uint64_t offset = 0, std::uint64_t line_number = 0)
      : file_(file), window_offset_(offset), line_number_(line_number) {}
  /// The next line without its end, valid until the next call; empty optional at the end of the file.
  std::optional<std::string_view> next_line();

  /// Fills `words` from the next line that is not blank; they are valid until the next call. False at the end
  /// of the file.
  bool next_words(std::vector<std::string_view>& words);

  /// Number of the line last returned, from 1.
  std::uint64_t line_number() const { return line_number_; }
  /// Byte after the line last returned, its end included.
  std::uint64_t offset() const { return window_offset_ + used_; }

  /// Throws an Error that names the line last returned.
  [[noreturn]] void fail(std::string problem, std::string expected = {}, std::string found = {}) const;

 private:
  std::optional<std::size_t> find_end();
  void refill();

  InputFile& file_;
  std::uint64_t window_offset_;
  std::string_view window_;
  std::size_t used_ = 0;       ///< bytes of the window already returned
  std::size_t line_feed_ = 0;  ///< offset of the first "\n" behind them, or the size of the window
  std::uint64_t line_number_;
};

/// Errors: a file that begins as text in UTF-16 does: with its byte order mark, or with 0 in every second
/// byte.
void reject_utf16(std::string_view start, const std::string& file);

/// Most columns of a point table: far beyond any real file, so that a header of nothing but columns is
/// rejected before anything is done for each of them.
inline constexpr std::size_t k_most_columns = 4096;

/// Errors: a table with more than k_most_columns; they name the line last returned.
void require_few_columns(const TextScanner& scanner, std::size_t count);

}  // namespace alidade
