// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <span>

#include "base/error.h"
#include "base/json.h"
#include "base/words.h"
#include "database/server/server_name.h"
#include "tools/command.h"
#include "tools/console.h"

namespace alidade::tools {
namespace {

/// "unknown KIND 'WORD'", with the known word it was probably meant to be.
std::string unknown(const std::string& kind, const std::string& word, const std::vector<std::string>& known) {
  const std::vector<std::string_view> views(known.begin(), known.end());
  const std::string_view nearest = nearest_word(word, views);
  return fmt::format("unknown {} '{}'", kind, word) +
         (nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest));
}

const Command* find_command(const std::vector<Command>& commands, const std::string& name) {
  const auto found = std::ranges::find_if(
      commands, [&](const Command& command) { return command.options->get_name() == name; });
  return found == commands.end() ? nullptr : &*found;
}

/// Explains a misspelt command or option better than the parser can; empty if there is none. `words` are
/// those where one of `commands` is expected.
std::string explain_unknown_word(std::span<const std::string> words, const std::vector<Command>& commands) {
  if (words.empty() || words[0].starts_with("-")) return {};
  const Command* const chosen = find_command(commands, words[0]);
  if (chosen == nullptr) {
    std::vector<std::string> command_names;
    for (const Command& command : commands) command_names.push_back(command.options->get_name());
    return unknown("command", words[0], command_names);
  }
  const bool needs_part = chosen->options->get_require_subcommand_min() > 0;
  const bool has_part = words.size() > 1 && find_command(chosen->parts, words[1]) != nullptr;
  if (needs_part || has_part) return explain_unknown_word(words.subspan(1), chosen->parts);

  std::vector<std::string> option_names;
  for (const CLI::Option* option : chosen->options->get_options()) {
    for (const std::string& name : option->get_lnames()) option_names.push_back("--" + name);
  }
  for (std::size_t i = 1; i < words.size() && words[i] != "--"; ++i) {
    const std::string option = words[i].substr(0, words[i].find('='));
    if (!option.starts_with("--")) continue;
    if (std::find(option_names.begin(), option_names.end(), option) == option_names.end()) {
      return unknown("option", option, option_names);
    }
    if (words[i].ends_with("=")) return fmt::format("option {} has no value behind its '='", option);
  }
  return {};
}

/// The command whose manual explains these words: "alidade query".
std::string manual_of(std::span<const std::string> words, const std::vector<Command>& commands) {
  std::string manual = "alidade";
  const std::vector<Command>* known = &commands;
  for (const std::string& word : words) {
    const Command* const command = find_command(*known, word);
    if (command == nullptr) break;
    manual += " " + word;
    known = &command->parts;
  }
  return manual;
}

ExitCode say_usage_error(const std::string& text, std::span<const std::string> words,
                         const std::vector<Command>& commands) {
  say_error(fmt::format("{}; see '{} --help'", text, manual_of(words, commands)));
  return ExitCode::failed;
}

/// Errors: a word, or what is behind its '=', names a table on a server in a way that might hold a password,
/// which no message may repeat.
void check_server_names(const CommandLine& words) {
  for (const std::string& word : words) {
    const std::size_t equals = word.starts_with("--") ? word.find('=') : std::string::npos;
    const std::string name = equals == std::string::npos ? word : word.substr(equals + 1);
    if (database::is_server_name(name)) database::ServerName{name};
  }
}

ExitCode run(const CommandLine& command_line) {
  check_server_names(command_line);
  CLI::App program("Alidade: ray queries on raw point clouds, and path-traced pictures of them.", "alidade");
  program.require_subcommand(1);
  program.set_version_flag("--version", ALIDADE_VERSION);
  program.footer(
      "'alidade COMMAND --help' is the manual of a command.\n"
      "\n"
      "Lengths are in the unit of the cloud's coordinate reference system, mostly metres; angles are in "
      "degrees; z is up.\n"
      "Data goes to files and stdout; progress and remarks go to stderr. An existing file is never replaced "
      "without\n"
      "--overwrite, and an output appears whole or not at all.\n"
      "Exit codes: 0 done, 1 the answer is no, 2 anything wrong, 130 interrupted.\n"
      "ALIDADE_INSTRUCTION_SET=scalar (or another set of the machine) chooses how queries are computed; "
      "answers are the same.\n");
  const std::vector<Command> commands = {add_info(program),    add_generate(program),
                                         add_index(program),   add_convert(program),
                                         add_query(program),   add_render(program, command_line),
                                         add_compare(program), add_visibility(program, command_line),
                                         add_sql(program)};
  // Behind the program's name.
  const auto words = std::span(command_line).subspan(std::min<std::size_t>(command_line.size(), 1));

  const std::string explanation = explain_unknown_word(words, commands);
  if (!explanation.empty()) return say_usage_error(explanation, words, commands);
  try {
    // The parser takes the words last one first.
    program.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::CallForHelp&) {
    write_to_stdout(program.help());
    return ExitCode::done;
  } catch (const CLI::CallForVersion&) {
    write_to_stdout("alidade " ALIDADE_VERSION "\n");
    return ExitCode::done;
  } catch (const CLI::ParseError& error) {
    return say_usage_error(error.what(), words, commands);
  }
  return run_chosen(commands);
}

}  // namespace

ExitCode run_chosen(const std::vector<Command>& commands) {
  return std::ranges::find_if(commands, [](const Command& command) { return command.options->parsed(); })
      ->run();
}

}  // namespace alidade::tools

int main(int argument_count, char** arguments) {
  using namespace alidade;
  using namespace alidade::tools;
  catch_interrupts();
  ExitCode code = ExitCode::failed;
  try {
    code = run(CommandLine(arguments, arguments + argument_count));
  } catch (const Cancelled&) {
    say_error("interrupted");
    code = ExitCode::interrupted;
  } catch (const ReaderGone&) {
    end_by_broken_pipe();
  } catch (const std::bad_alloc&) {
    say_error("not enough memory");
  } catch (const std::exception& error) {
    say_error(error.what());
  }
  return static_cast<int>(code);
}
