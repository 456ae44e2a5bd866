// SPDX-License-Identifier: MIT
#include "jobs/visibility/raster.h"

#include "tools/command.h"

namespace alidade::tools {

Command add_visibility_raster(const Options& visibility) {
  const Options raster =
      visibility.command("raster", "Compute a viewshed of the ground, or of objects from the ground")
          .also_called("viewshed");
  auto command = std::make_shared<JobCommand<jobs::RasterRequest>>();
  add_cloud(raster, command->request.files, {"--ignore-classes"});
  jobs::add_raster_fields(raster, command->request);
  add_run_options(raster, command->request.partial, command->request.threads, command->verbosity);
  return job_command(raster, command);
}

}  // namespace alidade::tools
