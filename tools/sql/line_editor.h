// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace alidade {

/// Where the program keeps what was typed at its prompt: $XDG_STATE_HOME/alidade/sql_history, or below
/// ~/.local/state; empty if there is no home.
std::filesystem::path sql_history_file();

/// Lines typed at a terminal, which can be edited and called back as in a shell. That is libedit's work,
/// which is loaded only here; without it lines are read as the terminal gives them.
class LineEditor {
 public:
  /// Earlier lines come from that file, if it can be read.
  explicit LineEditor(std::filesystem::path history);
  /// Writes the last 1000 lines to it, if it can be written.
  ~LineEditor();
  LineEditor(const LineEditor&) = delete;
  LineEditor& operator=(const LineEditor&) = delete;

  /// Waits for a line; none at the end of input, or if the program was interrupted meanwhile.
  std::optional<std::string> read(const std::string& prompt);

 private:
  struct Library;

  std::filesystem::path history_;
  std::unique_ptr<Library> library_;
};

}  // namespace alidade
