// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace alidade::tools {

/// An option or operand of a command, as its manual lists it.
struct OptionEntry {
  std::string heading{};             ///< of its group; empty: the first one
  std::vector<std::string> names{};  ///< "-o", "--output"; of an operand its one name, without hyphens
  std::string kind;                  ///< what follows the name: "FILE", "8|16"; empty for flags
  std::string help;
  bool is_operand = false;
};

/// The description of a command: the source of its help text, its manual page, and completions of shells.
struct CommandEntry {
  std::string name{};              ///< "alidade visibility raster"
  std::vector<std::string> words;  ///< all names of it below its group: "raster", "viewshed"
  std::string description{};
  std::string usage{};
  std::string text{};  ///< behind the options: forms, examples
  std::vector<OptionEntry> options{};
  std::vector<CommandEntry> parts{};  ///< commands of a group
};

/// A row of a manual: text in a second column, below a long first one on lines of its own. Ends with a line
/// end.
std::string manual_row(const std::string& first, std::string_view second, std::size_t column);

/// The help text, whose lines have at most 100 characters unless a word, or a line of `text`, is longer.
std::string help_text(const CommandEntry& command);

/// The manual page in the macros of man(7), section 1. `version`: of the program.
std::string manual_page(const CommandEntry& command, const std::string& version);

/// What bash, zsh and fish complete of a program's command line: commands, options, the words of choices, and
/// file names elsewhere.
std::string bash_completion(const CommandEntry& program);
std::string zsh_completion(const CommandEntry& program);
std::string fish_completion(const CommandEntry& program);

/// The pages of a program and of all its commands, and completions, by the names they have below a folder of
/// shared data: "man/man1/alidade-convert.1".
std::vector<std::pair<std::filesystem::path, std::string>> manual_files(const CommandEntry& program,
                                                                        const std::string& version);

}  // namespace alidade::tools
