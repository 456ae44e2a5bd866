// SPDX-License-Identifier: MIT

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <string_view>

#include "tools/command.h"

namespace alidade::tools {
namespace {

constexpr std::array<std::string_view, 5> k_flags = {"--overwrite", "--skip-existing", "--quiet", "--verbose",
                                                     "--resume"};
constexpr std::array<std::string_view, 8> k_options = {
    "--output",  "--threads",          "--legend",     "--legend-size",
    "--preview", "--preview-interval", "--checkpoint", "--checkpoint-interval"};

/// Flags that cannot change the picture: those of the list, and -q and -v alone or together.
bool is_silent_flag(std::string_view word) {
  if (std::ranges::find(k_flags, word) != k_flags.end()) return true;
  return word.size() > 1 && word[0] == '-' && word.find_first_not_of("qv", 1) == std::string_view::npos;
}

/// Options that cannot, whose value is the next word.
bool is_silent_option(std::string_view word) {
  return word == "-o" || std::ranges::find(k_options, word) != k_options.end();
}

/// The same with the value in the word.
bool holds_silent_option(std::string_view word) {
  if (word.starts_with("-o") && word.size() > 2) return true;
  const std::size_t end = word.find('=');
  return end != std::string_view::npos && is_silent_option(word.substr(0, end));
}

std::string quoted(const std::string& word) {
  return word.find_first_of(" \t'\"") == std::string::npos ? word : fmt::format("\"{}\"", word);
}

}  // namespace

std::string picture_command(const CommandLine& words) {
  std::string text = "alidade";
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (is_silent_flag(word) || holds_silent_option(word)) continue;
    if (is_silent_option(word)) {
      ++i;
    } else {
      text += " " + quoted(word);
    }
  }
  return text;
}

Command add_visibility(CLI::App& program, const CommandLine& command_line) {
  CLI::App* const visibility =
      program.add_subcommand("visibility", "Find what is seen from where, on the cloud itself");
  visibility->require_subcommand(1);
  visibility->footer("'alidade visibility COMMAND --help' is the manual of a command.\n");
  const std::vector<Command> parts = {add_visibility_points(*visibility),
                                      add_visibility_raster(*visibility, command_line),
                                      add_visibility_horizon(*visibility, command_line),
                                      add_visibility_sky(*visibility, command_line),
                                      add_visibility_sun(*visibility, command_line),
                                      add_visibility_lines(*visibility, command_line),
                                      add_visibility_place(*visibility, command_line)};
  return {visibility, [parts] { return run_chosen(parts); }, parts};
}

}  // namespace alidade::tools
