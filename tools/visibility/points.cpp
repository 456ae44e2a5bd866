// SPDX-License-Identifier: MIT
#include "jobs/visibility/points.h"

#include "tools/command.h"

namespace alidade::tools {

Command add_visibility_points(const Options& visibility) {
  const Options points =
      visibility.command("points", "Compute the visibility of every point, and what blocks it");
  auto command = std::make_shared<JobCommand<jobs::PointsRequest>>();
  add_cloud(points, command->request.files, {"--ignore-classes"});
  jobs::add_points_fields(points, command->request);
  add_run_options(points, command->request.partial, command->request.threads, command->verbosity);
  return job_command(points, command);
}

}  // namespace alidade::tools
