// SPDX-License-Identifier: MIT
#include "jobs/query/query.h"

#include <fmt/format.h>
#include <unistd.h>

#include "tools/command.h"

namespace alidade::tools {
namespace {

/// The table of --explain: counts, those of each target, and shares.
std::string work_table(const std::vector<jobs::WorkCount>& work, std::string_view target) {
  std::string text = fmt::format("{:<22}{:>16}{:>16}\n", "", "in all", fmt::format("per {}", target));
  const auto share = [](std::uint64_t count, std::uint64_t of) {
    return of > 0 ? static_cast<double>(count) / static_cast<double>(of) : 0.0;
  };
  for (const jobs::WorkCount& one : work) {
    text += fmt::format("{:<22}{:>16}", one.name, one.count);
    // The targets come first.
    if (one.is_per_target) text += fmt::format("{:>16.2f}", share(one.count, work.front().count));
    if (one.of) text += fmt::format("{:>15.2f}%", 100.0 * share(one.count, *one.of));
    text += "\n";
  }
  return text;
}

}  // namespace

Command add_query(const Options& program) {
  const Options query = program.command(
      "query", "Find the points near rays, paths and positions, and in cones, planes and boxes");
  const auto command = std::make_shared<JobCommand<jobs::QueryRequest>>();
  command->request.write_text = write_to_stdout;
  command->request.is_text_shown = ::isatty(STDOUT_FILENO) == 1;
  jobs::add_query_fields(query, command->request);
  add_job_options(query, *command);
  return job_command(query, command, [](const jobs::QueryPlan& plan, const jobs::QueryResult& result) {
    if (plan.request().explain)
      write_to_stderr(work_table(result.work, jobs::target_kind(plan.request().family).name));
    return ExitCode::done;
  });
}

}  // namespace alidade::tools
