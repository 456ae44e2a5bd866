// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_file.h"

namespace alidade::tools {

/// Some whole lines of a text.
struct LineBlock {
  std::string text;
  std::vector<std::size_t> ends;   ///< of every line, behind its last character; the next begins after a "\n"
  std::uint64_t first_number = 1;  ///< of its first line in the text

  std::size_t size() const { return ends.size(); }
  /// Without "\n" and "\r\n".
  std::string_view line(std::size_t i) const;
};

/// A text that targets are read from, line by line and once: a file, a pipe, standard input, or values on the
/// command line. Memory: two mebibytes. Not thread safe.
class LineSource {
 public:
  /// Opens a file, or standard input for "-". Errors: it cannot be opened.
  static LineSource open(const std::string& name);
  /// The values of an option, one per line.
  static LineSource command_line(std::string option, const std::vector<std::string>& values);

  /// Its name in messages.
  const std::string& name() const { return name_; }
  bool is_command_line() const { return !descriptor_.is_open(); }
  /// Bytes of lines returned so far, and bytes in all, 0 if that is not known.
  std::uint64_t done() const { return done_; }
  std::uint64_t total() const { return total_; }

  /// The next lines, about a mebibyte of them; false at the end. A byte order mark is left out. Errors:
  /// reading failed; a line longer than a mebibyte. Cancelled, if the program is interrupted.
  bool next(LineBlock& block);

 private:
  LineSource(std::string name, FileDescriptor descriptor)
      : name_(std::move(name)), descriptor_(std::move(descriptor)) {}
  bool read_more();

  std::string name_;
  FileDescriptor descriptor_;  ///< none: everything is in `waiting_`
  std::string waiting_;
  std::uint64_t next_number_ = 1, done_ = 0, total_ = 0;
};

}  // namespace alidade::tools
