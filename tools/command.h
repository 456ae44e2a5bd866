// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "tools/console.h"

// A sub-command is one function: it declares its options on the program and returns what to do when it is
// chosen. Work is done by the libraries; a command only reads options, calls, and prints. Bad input is thrown
// as Error.

namespace alidade::tools {

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

/// `alidade sql load`.
Command add_sql_load(CLI::App& sql);

/// `alidade sql load`.
Command add_sql_shard_plan(CLI::App& sql);

// The commands of `alidade visibility`.

Command add_visibility_lines(CLI::App& visibility, const CommandLine& command_line);
Command add_visibility_place(CLI::App& visibility, const CommandLine& command_line);
Command add_visibility_points(CLI::App& visibility);
Command add_visibility_raster(CLI::App& visibility, const CommandLine& command_line);
Command add_visibility_horizon(CLI::App& visibility, const CommandLine& words);
Command add_visibility_sky(CLI::App& visibility, const CommandLine& words);
Command add_visibility_sun(CLI::App& visibility, const CommandLine& words);

/// The command line as metadata keep it: without the words that only say where the picture goes, how it is
/// computed and who watches, so that the same picture is the same file.
std::string picture_command(const CommandLine& words);

}  // namespace alidade::tools
