// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "octree/error.h"
#include "renderer/json_reader.h"
#include "tools/command.h"
#include "tools/interrupt.h"
#include "tools/message.h"

namespace alidade {
namespace {

/// "unknown KIND 'WORD'", with the known word it was probably meant to be.
std::string unknown(const std::string& kind, const std::string& word, const std::vector<std::string>& known) {
  const std::vector<std::string_view> views(known.begin(), known.end());
  const std::string_view nearest = nearest_word(word, views);
  return fmt::format("unknown {} '{}'", kind, word) +
         (nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest));
}

/// Explains a misspelt command or option better than the parser can; empty if there is none.
std::string explain_unknown_word(const CommandLine& words, const std::vector<Command>& commands) {
  if (words.size() < 2 || words[1].starts_with("-")) return {};
  std::vector<std::string> command_names;
  const CLI::App* chosen = nullptr;
  for (const Command& command : commands) {
    command_names.push_back(command.options->get_name());
    if (command_names.back() == words[1]) chosen = command.options;
  }
  if (chosen == nullptr) return unknown("command", words[1], command_names);

  std::vector<std::string> option_names;
  for (const CLI::Option* option : chosen->get_options()) {
    for (const std::string& name : option->get_lnames()) option_names.push_back("--" + name);
  }
  for (std::size_t i = 2; i < words.size() && words[i] != "--"; ++i) {
    const std::string option = words[i].substr(0, words[i].find('='));
    if (!option.starts_with("--")) continue;
    if (std::find(option_names.begin(), option_names.end(), option) == option_names.end()) {
      return unknown("option", option, option_names);
    }
    if (words[i].ends_with("=")) return fmt::format("option {} has no value behind its '='", option);
  }
  return {};
}

ExitCode say_usage_error(const std::string& text, const CommandLine& words,
                         const std::vector<Command>& commands) {
  std::string manual = "alidade --help";
  for (const Command& command : commands) {
    const std::string name = command.options->get_name();
    if (words.size() > 1 && words[1] == name) manual = "alidade " + name + " --help";
  }
  say_error(text + "; see '" + manual + "'");
  return ExitCode::failed;
}

ExitCode run(const CommandLine& words) {
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
  const std::vector<Command> commands = {add_info(program), add_generate(program), add_index(program),
                                         add_query(program), add_render(program, words)};

  const std::string explanation = explain_unknown_word(words, commands);
  if (!explanation.empty()) return say_usage_error(explanation, words, commands);
  try {
    // The parser takes the words after the program's name, last one first.
    program.parse(std::vector<std::string>(words.rbegin(), words.rend() - 1));
  } catch (const CLI::CallForHelp&) {
    write_to_stdout(program.help());
    return ExitCode::done;
  } catch (const CLI::CallForVersion&) {
    write_to_stdout("alidade " ALIDADE_VERSION "\n");
    return ExitCode::done;
  } catch (const CLI::ParseError& error) {
    return say_usage_error(error.what(), words, commands);
  }
  const auto chosen = std::find_if(commands.begin(), commands.end(),
                                   [](const Command& command) { return command.options->parsed(); });
  return chosen->run();
}

}  // namespace
}  // namespace alidade

int main(int argument_count, char** arguments) {
  using namespace alidade;
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
