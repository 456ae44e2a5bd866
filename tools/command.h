// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "jobs/plan.h"
#include "tools/console.h"
#include "tools/options.h"

// A sub-command is one function: it declares its options on the program and returns the function that runs
// it. The libraries do the work; a command only reads options, calls the libraries, and prints. Invalid input
// is thrown as Error.

namespace alidade::tools {

using jobs::is_silent;
using jobs::k_silent_flags;
using jobs::k_silent_options;
using jobs::kept_name;

/// Runs a chosen command.
using Run = std::function<ExitCode(const CommandLine&)>;

/// A declared command.
struct Command {
  Options options;
  Run run;  ///< empty for a group that does nothing itself
  /// The commands of a group. One of them follows the group's name, or may, if the group has a `run` itself.
  std::vector<Command> parts{};
};

/// The number of threads that suits a command line, whose first word is the program's name; empty: as many as
/// the machine has. It is 8 per core if a command that queries rays is given an index file larger than
/// `memory` (bytes): most threads then wait for the disk, which serves many as fast as one.
std::optional<int> enough_threads(std::span<const std::string> words, std::uint64_t memory);

/// Returns what `work` returns, run on exactly this many threads; by default enough_threads() of the words.
ExitCode with_threads(std::optional<int> threads, std::span<const std::string> words,
                      const std::function<ExitCode()>& work);

/// The command line for metadata: names as kept_name(), without the options that do not affect the image
/// (outputs, threads, messages), so that equal images make equal files.
std::string metadata_command(const CommandLine& words);

/// A command that calls `run(*request)`, on the requested number of threads, by default on enough_threads().
template <class Request>
Command command_of(const Options& options, const std::shared_ptr<Request>& request,
                   ExitCode (*run)(const Request&)) {
  return {options, [request, run](const CommandLine& words) {
            request->words = words;
            return with_threads(request->threads, words, [&] { return run(*request); });
          }};
}

/// A command that is a job: its request, and what only a command line has.
template <class Request>
struct JobCommand {
  Request request;
  std::optional<int> threads;
  Verbosity verbosity = Verbosity::normal;
  bool is_dry_run = false;
};

/// Declares --threads, -q and -v.
template <class Request>
void add_job_options(const Options& options, JobCommand<Request>& command) {
  add_threads(options, command.threads);
  add_verbosity(options, command.verbosity);
}

/// A command that plans and runs the job, or with --dry-run, which it declares, prints the plan.
/// `show(plan, result)` prints what belongs on stdout, and returns the exit code.
template <class Request, class Show>
Command job_command(const Options& options, const std::shared_ptr<JobCommand<Request>>& command, Show show) {
  options.flag("--dry-run",
               "check the command, print what it would read and write and how much memory it would need, and "
               "do no more",
               command->is_dry_run);
  return {options, [command, show](const CommandLine& words) {
            if constexpr (requires { command->request.command; })
              command->request.command = metadata_command(words);
            return with_threads(command->threads, words, [&] {
              Console console(command->verbosity);
              const auto checked = plan(command->request);
              if (!command->is_dry_run) return show(checked, run(checked, console));
              write_to_stdout(jobs::text_of(checked.work()));
              return ExitCode::done;
            });
          }};
}

/// A job that prints nothing on stdout; its exit code is ExitCode::done unless it fails.
template <class Request>
Command job_command(const Options& options, const std::shared_ptr<JobCommand<Request>>& command) {
  return job_command(options, command, [](const auto&, const auto&) { return ExitCode::done; });
}

/// A job whose fields `add_fields` declares, with add_job_options(); `show` as above.
template <class Request, class... Show>
Command job_command(const Options& options, void (*add_fields)(const Fields&, Request&), Show... show) {
  const auto command = std::make_shared<JobCommand<Request>>();
  add_fields(options, command->request);
  add_job_options(options, *command);
  return job_command(options, command, show...);
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
Command add_visibility(const Options& program);
Command add_sql(const Options& program);
Command add_formats(const Options& program);
Command add_manual(const Options& program);

/// A command that an extension adds.
struct AddedCommand {
  std::string_view group;                    ///< its group, such as "visibility"; empty: none
  Command (*declare)(const Options& group);  ///< declares it in the group, or in the program
};

/// What extensions add to the program.
struct ProgramHooks {
  std::vector<AddedCommand> commands;  ///< listed behind the commands of the core
};

/// Adds what every extension adds that the program is built with. Defined by the build, in the program.
void add_extensions(ProgramHooks& hooks);

/// The output of 'alidade --version': the version in its first line, then the instruction set that queries
/// use on this machine, the compiler, and the libraries that were compiled in, those that are loaded when
/// needed last.
std::string version_text();

/// Runs a command line, whose first word is the program's name. Errors: those of the commands.
ExitCode run_program(const CommandLine& command_line, const ProgramHooks& extensions);

}  // namespace alidade::tools
