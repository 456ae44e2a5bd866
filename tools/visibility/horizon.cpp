// SPDX-License-Identifier: MIT
#include "jobs/visibility/horizon.h"

#include "tools/command.h"

namespace alidade::tools {

Command add_visibility_horizon(const Options& visibility) {
  const Options horizon =
      visibility.command("horizon", "Compute the horizon, sky-view factors and a panorama at one position");
  auto command = std::make_shared<JobCommand<jobs::HorizonRequest>>();
  add_cloud(horizon, command->request.files, {"--ignore-classes"});
  jobs::add_horizon_fields(horizon, command->request);
  add_run_options(horizon, command->request.partial, command->request.threads, command->verbosity);
  return job_command(horizon, command, [](const jobs::HorizonPlan& plan, const jobs::HorizonResult& result) {
    if (plan.request().output.empty()) write_to_stdout(visibility::horizon_csv(result.line));
    return ExitCode::done;
  });
}

}  // namespace alidade::tools
