// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/huge_memory.h"
#include "tools/console.h"
#include "tools/options.h"
#include "tools/threads.h"

// A sub-command is one function: it declares its options on the program and returns the function that runs
// it. The libraries do the work; a command only reads options, calls the libraries, and prints. Invalid input
// is thrown as Error.

namespace alidade::tools {

/// Runs a chosen command.
using Run = std::function<ExitCode(const CommandLine&)>;

/// A declared command.
struct Command {
  Options options;
  Run run;  ///< empty for a group that does nothing itself
  /// The commands of a group. One of them follows the group's name, or may, if the group has a `run` itself.
  std::vector<Command> parts{};
};

/// A command that calls `run(*request)`, on the requested number of threads, by default on enough_threads().
template <class Request>
Command command_of(const Options& options, const std::shared_ptr<Request>& request,
                   ExitCode (*run)(const Request&)) {
  return {options, [request, run](const CommandLine& words) {
            request->words = words;
            const auto threads = request->threads
                                     ? request->threads
                                     : enough_threads(words, available_memory().value_or(UINT64_MAX));
            return with_threads(threads, [&] { return run(*request); });
          }};
}

Command add_info(const Options& program);
Command add_generate(const Options& program);
Command add_index(const Options& program);
Command add_catalog(const Options& program);
Command add_convert(const Options& program);
Command add_query(const Options& program);
Command add_render(const Options& program);
Command add_merge(const Options& program);
Command add_compare(const Options& program);
Command add_change(const Options& program);
Command add_sql(const Options& program);
Command add_formats(const Options& program);
Command add_manual(const Options& program);

/// The output of 'alidade --version': the version in its first line, then the instruction set that queries
/// use on this machine, the compiler, and the libraries that are linked, those of the module for images and
/// maps last.
std::string version_text();

/// Runs a command line, whose first word is the program's name. Errors: those of the commands.
ExitCode run_program(const CommandLine& command_line);

/// `alidade sql load`, `alidade sql rewrite` and `alidade sql shard-plan`.
Command add_sql_load(const Options& sql);
Command add_sql_rewrite(const Options& sql);
Command add_sql_shard_plan(const Options& sql);

// The commands of `alidade visibility`.

Command add_visibility_lines(const Options& visibility);
Command add_visibility_photos(const Options& visibility);
Command add_visibility_place(const Options& visibility);
Command add_visibility_summary(const Options& visibility);
Command add_visibility_points(const Options& visibility);
Command add_visibility_raster(const Options& visibility);
Command add_visibility_horizon(const Options& visibility);
Command add_visibility_sky(const Options& visibility);
Command add_visibility_sun(const Options& visibility);

/// A file's name for metadata, which other people read: the last part of an absolute path, public_name() of a
/// URL, other names as they are.
std::string kept_name(const std::filesystem::path& given);

/// The command line for metadata: names as kept_name(), without the options that do not affect the picture
/// (outputs, threads, messages), so that equal pictures make equal files.
std::string metadata_command(const CommandLine& words);

}  // namespace alidade::tools
