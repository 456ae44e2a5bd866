// SPDX-License-Identifier: MIT
#include "jobs/visibility/summary.h"

#include "tools/command.h"

namespace alidade::tools {

Command add_visibility_summary(const Options& visibility) {
  const Options summary = visibility.command("summary", "Summarize what each observer sees in one row");
  auto command = std::make_shared<JobCommand<jobs::SummaryRequest>>();
  add_cloud(summary, command->request.files, {"--ignore-classes"});
  jobs::add_summary_fields(summary, command->request);
  add_run_options(summary, command->request.partial, command->request.threads, command->verbosity);
  return job_command(summary, command);
}

}  // namespace alidade::tools
