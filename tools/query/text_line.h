// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace alidade {

/// A line of a text, with what is needed to say where something in it is wrong.
struct TextLine {
  std::string_view source;  ///< what messages call the text: a file, or an option of the command line
  bool is_command_line = false;
  std::string_view text;
  std::uint64_t number = 1;

  /// Throws the Error for what stands at byte `offset`. It names source, line and column (in characters,
  /// from 1); of an option instead all of its value.
  [[noreturn]] void fail(std::size_t offset, std::string problem, std::string expected = {},
                         std::string found = {}) const;
};

}  // namespace alidade
