// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "tools/exit_code.h"

// A sub-command is one function: it declares its options on the program and returns what to do when it is
// chosen. Work is done by the libraries; a command only reads options, calls, and prints. Bad input is thrown
// as Error.

namespace alidade {

/// Runs a chosen command.
using Run = std::function<ExitCode()>;

/// A declared command.
struct Command {
  CLI::App* options;  ///< owned by the program
  Run run;
  /// Of a group of commands: those of which one follows its name, or may, if the group does something itself.
  std::vector<Command> parts{};
};

/// The words the program was started with, as they go into the metadata of what it writes.
using CommandLine = std::vector<std::string>;

Command add_info(CLI::App& program);
Command add_generate(CLI::App& program);
Command add_index(CLI::App& program);
Command add_convert(CLI::App& program);
Command add_query(CLI::App& program);
Command add_render(CLI::App& program, const CommandLine& command_line);
Command add_compare(CLI::App& program);
Command add_visibility(CLI::App& program, const CommandLine& command_line);
Command add_sql(CLI::App& program);

/// Runs the one of these commands that was chosen.
ExitCode run_chosen(const std::vector<Command>& commands);

}  // namespace alidade
