// SPDX-License-Identifier: MIT
#include "jobs/visibility/lines.h"

#include "tools/command.h"

namespace alidade::tools {

Command add_visibility_lines(const Options& visibility) {
  const Options lines =
      visibility.command("lines", "Test lines of sight between pairs of positions, and their Fresnel zones");
  auto command = std::make_shared<JobCommand<jobs::LinesRequest>>();
  add_cloud(lines, command->request.files, {"--ignore-classes"});
  jobs::add_lines_fields(lines, command->request);
  add_run_options(lines, command->request.partial, command->request.threads, command->verbosity);
  return job_command(lines, command);
}

}  // namespace alidade::tools
