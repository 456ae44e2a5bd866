// SPDX-License-Identifier: MIT
#include "jobs/visibility/sun.h"

#include "tools/command.h"

namespace alidade::tools {

Command add_visibility_sun(const Options& visibility) {
  const Options sun = visibility.command(
      "sun", "Compute hours of direct sun and radiation on points, on the ground or at positions");
  auto command = std::make_shared<JobCommand<jobs::SunRequest>>();
  add_cloud(sun, command->request.files, {"--ignore-classes"});
  jobs::add_sun_fields(sun, command->request);
  add_run_options(sun, command->request.partial, command->request.threads, command->verbosity);
  return job_command(sun, command);
}

}  // namespace alidade::tools
