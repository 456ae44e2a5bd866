// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace alidade {

/// Walks through a text line by line; CR LF and LF end a line, the last one may lack its end.
class LineWalk {
 public:
  explicit LineWalk(std::string_view text) : rest_(text) {}
  /// The next line without its end; false at the end of the text.
  bool next(std::string_view& line);
  /// Number of the line given last, from 1.
  std::uint64_t number() const { return number_; }

 private:
  std::string_view rest_;
  std::uint64_t number_ = 0;
};

/// Takes a line apart at blanks, tabs and commas. Errors, without file and place: a field that is missing or
/// not what it should be.
class FieldWalk {
 public:
  explicit FieldWalk(std::string_view line) : rest_(line) {}

  bool at_end();
  std::string_view word(const char* what);
  double number(const char* what);  ///< finite
  std::uint64_t whole_number(const char* what, std::uint64_t most);
  /// All that is left, without blanks around it.
  std::string_view rest();

 private:
  std::string_view rest_;
};

/// A finite number and nothing else, the same bits on every machine. Errors: as FieldWalk.
double number_of(std::string_view text, const char* what);

}  // namespace alidade
