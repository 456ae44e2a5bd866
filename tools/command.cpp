// SPDX-License-Identifier: MIT
#include "tools/command.h"

#include <fmt/format.h>
#include <hwy/highway.h>
#include <sqlite3.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/version.h>
#include <CLI/Version.hpp>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/instruction_set.h"
#include "base/words.h"
#include "cloud/crs.h"
#include "geo/crs_library.h"
#include "geo/gdal_library.h"
#include "image/image_file.h"
#include "jobs/cloud_formats.h"
#include "jobs/remote_files.h"
#include "jobs/render/render.h"

namespace alidade::tools {
namespace {

template <class Names>
bool names_one_of(std::string_view word, const Names& names) {
  return word.starts_with("--") && std::ranges::find(names, word.substr(2)) != names.end();
}

/// Flags that cannot change the image: those of the list, and -q and -v alone or together.
bool is_silent_flag(std::string_view word) {
  if (names_one_of(word, k_silent_flags)) return true;
  return word.size() > 1 && word[0] == '-' && word.find_first_not_of("qv", 1) == std::string_view::npos;
}

/// Options that cannot change the image, with the value in the next word.
bool is_silent_option(std::string_view word) {
  return word == "-o" || names_one_of(word, k_silent_options) ||
         names_one_of(word, jobs::k_silent_image_options);
}

/// Options that cannot change the image, with the value in the word itself.
bool holds_silent_option(std::string_view word) {
  if (word.starts_with("-o") && word.size() > 2) return true;
  const std::size_t end = word.find('=');
  return end != std::string_view::npos && is_silent_option(word.substr(0, end));
}

/// "unknown KIND 'WORD'", with the known word it was probably meant to be.
std::string unknown(const std::string& kind, const std::string& word, const std::vector<std::string>& known) {
  const std::vector<std::string_view> views(known.begin(), known.end());
  const std::string_view nearest = nearest_word(word, views);
  return fmt::format("unknown {} '{}'", kind, word) +
         (nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest));
}

const Command* find_command(const std::vector<Command>& commands, const std::string& name) {
  const auto found =
      std::ranges::find_if(commands, [&](const Command& command) { return command.options.is_called(name); });
  return found == commands.end() ? nullptr : &*found;
}

/// Explains a misspelt command or option better than the parser can; empty if there is none. `words` are
/// those where one of `commands` is expected.
std::string explain_unknown_word(std::span<const std::string> words, const std::vector<Command>& commands) {
  if (words.empty() || words[0].starts_with("-")) return {};
  const Command* const chosen = find_command(commands, words[0]);
  if (chosen == nullptr) {
    // A command is easily typed without its group.
    for (const Command& group : commands)
      if (find_command(group.parts, words[0]) != nullptr)
        return fmt::format("unknown command '{}'; did you mean '{} {}'?", words[0], group.options.name(),
                           words[0]);
    std::vector<std::string> command_names;
    for (const Command& command : commands) command_names.push_back(command.options.name());
    return unknown("command", words[0], command_names);
  }
  const bool has_part = words.size() > 1 && find_command(chosen->parts, words[1]) != nullptr;
  if (!chosen->run || has_part) return explain_unknown_word(words.subspan(1), chosen->parts);

  const std::vector<std::string> option_names = chosen->options.long_names();
  for (std::size_t i = 1; i < words.size() && words[i] != "--"; ++i) {
    const std::string option = words[i].substr(0, words[i].find('='));
    if (!option.starts_with("--")) continue;
    if (std::find(option_names.begin(), option_names.end(), option) == option_names.end())
      return unknown("option", option, option_names);
    if (words[i].ends_with("=")) return fmt::format("missing value after '=' of option {}", option);
  }
  return {};
}

/// The words in front that name a command: "visibility raster".
std::span<const std::string> command_of_words(std::span<const std::string> words,
                                              const std::vector<Command>& commands) {
  std::size_t count = 0;
  const std::vector<Command>* known = &commands;
  for (; count < words.size(); ++count) {
    const Command* const command = find_command(*known, words[count]);
    if (command == nullptr) break;
    known = &command->parts;
  }
  return words.first(count);
}

ExitCode say_usage_error(const std::string& text, std::span<const std::string> words,
                         const std::vector<Command>& commands) {
  std::string manual = "alidade";
  for (const std::string& word : command_of_words(words, commands)) manual += " " + word;
  say_error(fmt::format("{}; see '{} --help'", text, manual));
  return ExitCode::failed;
}

/// Errors: a word, or the text behind its '=', names a table on a server in a way that might contain a
/// password, which no message may repeat.
void check_server_names(const CommandLine& words) {
  for (const std::string& word : words) {
    const std::size_t equals = word.starts_with("--") ? word.find('=') : std::string::npos;
    const std::string name = equals == std::string::npos ? word : word.substr(equals + 1);
    if (const jobs::AddedFormat* const server = jobs::server_of(name)) server->shown(name);
  }
}

/// Declares a command of an extension. Requires: there is such a group.
void add_command(std::vector<Command>& commands, const Options& program, const AddedCommand& added) {
  if (added.group.empty()) {
    commands.push_back(added.declare(program));
    return;
  }
  Command& group = *std::ranges::find(commands, added.group,
                                      [](const Command& command) { return command.options.name(); });
  group.parts.push_back(added.declare(group.options));
}

/// Declares the commands that the words may name: one of the core alone, if the first word is its name, since
/// declaring them all takes longer than most of them do; none for the version; otherwise all.
std::vector<Command> declare_commands(const Options& program, std::span<const std::string> words,
                                      const ProgramHooks& extensions) {
  struct CoreCommand {
    std::string_view name;
    Command (*declare)(const Options& program);
  };
  constexpr CoreCommand k_core[] = {{"info", add_info},       {"generate", add_generate},
                                    {"index", add_index},     {"catalog", add_catalog},
                                    {"convert", add_convert}, {"query", add_query},
                                    {"render", add_render},   {"merge", add_merge},
                                    {"compare", add_compare}, {"visibility", add_visibility},
                                    {"sql", add_sql}};
  std::vector<Command> commands;
  if (words.size() == 1 && words[0] == "--version") return commands;
  const auto* const named = std::ranges::find(k_core, words.empty() ? "" : words[0], &CoreCommand::name);
  const bool is_named = named != std::end(k_core);
  for (const CoreCommand& command : is_named ? std::span(named, 1) : std::span(k_core))
    commands.push_back(command.declare(program));
  for (const AddedCommand& added : extensions.commands)
    if (!is_named || added.group == named->name) add_command(commands, program, added);
  if (is_named) return commands;
  commands.push_back(add_formats(program));
  commands.push_back(add_manual(program));
  return commands;
}

/// Runs the chosen one of these commands or of their parts.
ExitCode run_chosen(const std::vector<Command>& commands, const CommandLine& words) {
  const auto is_chosen = [](const Command& command) { return command.options.chosen(); };
  const Command& command = *std::ranges::find_if(commands, is_chosen);
  return std::ranges::any_of(command.parts, is_chosen) ? run_chosen(command.parts, words)
                                                       : command.run(words);
}

}  // namespace

std::optional<int> enough_threads(std::span<const std::string> words, std::uint64_t memory) {
  constexpr std::array<std::string_view, 10> k_without_rays = {
      "info", "generate", "index", "catalog", "convert", "merge", "compare", "sql", "formats", "manual"};
  if (words.size() < 2 || std::ranges::find(k_without_rays, words[1]) != k_without_rays.end())
    return std::nullopt;
  const bool waits = std::ranges::any_of(words, [&](const std::string& word) {
    std::error_code error;
    return has_extension(word, {".alidade"}) && std::filesystem::is_regular_file(word, error) &&
           std::filesystem::file_size(word, error) > memory;
  });
  constexpr int k_waiting_per_core = 8;
  if (!waits) return std::nullopt;
  return std::min(k_waiting_per_core * tbb::this_task_arena::max_concurrency(), k_most_threads);
}

ExitCode with_threads(std::optional<int> threads, std::span<const std::string> words,
                      const std::function<ExitCode()>& work) {
  if (!threads) threads = enough_threads(words, available_memory().value_or(UINT64_MAX));
  if (!threads) return work();
  // The limit allows more threads than the machine has; the arena then requests them.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(*threads));
  tbb::task_arena arena(*threads);
  return arena.execute(work);
}

std::string metadata_command(const CommandLine& words) {
  std::string text = "alidade";
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::size_t value = words[i].starts_with("--") ? words[i].find('=') + 1 : 0;
    const std::string word = words[i].substr(0, value) + kept_name(words[i].substr(value));
    if (is_silent_flag(word) || holds_silent_option(word)) continue;
    if (is_silent_option(word)) {
      ++i;
    } else {
      const bool is_plain = word.find_first_of(" \t'\"") == std::string::npos;
      text += is_plain ? " " + word : fmt::format(" \"{}\"", word);
    }
  }
  return text;
}

std::string version_text() {
  return fmt::format("alidade " ALIDADE_VERSION
                     "\ninstruction set: {}\ncompiler: {}\nlibraries: oneTBB {}.{}, Highway {}.{}.{}, fmt "
                     "{}.{}.{}, SQLite {}, "
                     "nlohmann_json {}.{}.{}, CLI11 {}\nloaded when needed: {}, {}\n",
                     name(best_instruction_set()), __VERSION__, TBB_VERSION_MAJOR, TBB_VERSION_MINOR,
                     HWY_MAJOR, HWY_MINOR, HWY_PATCH, FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                     FMT_VERSION % 100, sqlite3_libversion(), NLOHMANN_JSON_VERSION_MAJOR,
                     NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH, CLI11_VERSION,
                     image::library_version(), geo::library_version());
}

ExitCode run_program(const CommandLine& command_line, const ProgramHooks& extensions) {
  check_server_names(command_line);
  jobs::set_remote_user({&interrupted, &say_remote_note, &confirm});
  use_crs_library({.compare = &geo::compare_systems, .wkt = &geo::library_wkt});
  // Behind the program's name.
  CommandLine words(command_line.begin() + std::min<std::ptrdiff_t>(std::ssize(command_line), 1),
                    command_line.end());
  // "help COMMAND" is "COMMAND --help".
  if (!words.empty() && words.front() == "help") {
    std::rotate(words.begin(), words.begin() + 1, words.end());
    words.back() = "--help";
  }
  Parser parser;
  const std::vector<Command> commands = declare_commands(parser.program(), words, extensions);

  const std::string explanation = explain_unknown_word(words, commands);
  if (!explanation.empty()) return say_usage_error(explanation, words, commands);
  // Options read files that the manual does not need.
  const auto asks_for_help = [](const std::string& word) { return word == "--help" || word == "-h"; };
  if (std::any_of(words.begin(), std::ranges::find(words, "--"), asks_for_help)) {
    words.resize(command_of_words(words, commands).size());
    words.push_back("--help");
  }
  try {
    switch (parser.parse(words)) {
      case Parser::Action::help:
        write_to_stdout(parser.help());
        return ExitCode::done;
      case Parser::Action::version:
        write_to_stdout(version_text());
        return ExitCode::done;
      case Parser::Action::work:
        break;
    }
  } catch (const UsageError& error) {
    return say_usage_error(error.what(), words, commands);
  }
  return run_chosen(commands, command_line);
}

}  // namespace alidade::tools
