// SPDX-License-Identifier: MIT
#include "jobs/visibility/sky.h"

#include "tools/command.h"

namespace alidade::tools {

Command add_visibility_sky(const Options& visibility) {
  const Options sky = visibility.command("sky", "Compute sky-view factors of points or of the ground");
  auto command = std::make_shared<JobCommand<jobs::SkyRequest>>();
  add_cloud(sky, command->request.files, {"--ignore-classes"});
  jobs::add_sky_fields(sky, command->request);
  add_run_options(sky, command->request.partial, command->request.threads, command->verbosity);
  return job_command(sky, command);
}

}  // namespace alidade::tools
