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

// A sub-command is one function: it declares its options on the program and returns what to do when it is
// chosen. Work is done by the libraries; a command only reads options, calls, and prints. Bad input is thrown
// as Error.

namespace alidade::tools {

/// Runs a chosen command.
using Run = std::function<ExitCode(const CommandLine&)>;

/// A declared command.
struct Command {
  Options options;
  Run run;  ///< empty for a group that does nothing itself
  /// Of a group: the commands of which one follows its name, or may, if the group does something itself.
  std::vector<Command> parts{};
};

/// A command that is `run(*request)`, on as many threads as the request wants, otherwise on enough_threads().
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

/// What 'alidade --version' prints: the version in its first line, then the instruction set that queries use on
/// this machine, the compiler, and the libraries that are linked, those of the module for images and maps last.
std::string version_text();

/// Runs what the command line requests, whose first word is the program's name. Errors: those of the commands.
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

/// A file's name as metadata keep it, which go to other people: of an absolute path the last part alone, of a URL
/// public_name().
std::string kept_name(const std::filesystem::path& given);

/// The command line as metadata keep it: names as kept_name(), without the words that only say where the picture goes,
/// how it is computed and who watches, so that the same picture is the same file.
std::string picture_command(const CommandLine& words);

}  // namespace alidade::tools
