// SPDX-License-Identifier: MIT
// The commands of `alidade visibility`. Each runs a job.
#include "jobs/visibility/horizon.h"
#include "jobs/visibility/lines.h"
#include "jobs/visibility/points.h"
#include "jobs/visibility/raster.h"
#include "jobs/visibility/sky.h"
#include "jobs/visibility/summary.h"
#include "jobs/visibility/sun.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

/// The rows of a horizon without an output.
ExitCode show_horizon(const jobs::HorizonPlan& plan, const jobs::HorizonResult& result) {
  if (plan.request().output.empty()) write_to_stdout(visibility::horizon_csv(result.line));
  return ExitCode::done;
}

}  // namespace

Command add_visibility(const Options& program) {
  const Options group = program.command("visibility", "Compute visibility on the points").require_command();
  const auto named = [&](const char* name, const char* description) {
    return group.command(name, description);
  };
  return {
      group,
      {},
      {job_command(named("points", "Compute the visibility of every point, and what blocks it"),
                   jobs::add_points_fields),
       job_command(named("raster", "Compute a viewshed of the ground, or of objects from the ground")
                       .also_called("viewshed"),
                   jobs::add_raster_fields),
       job_command(named("horizon", "Compute the horizon, sky-view factors and a panorama at one position"),
                   jobs::add_horizon_fields, show_horizon),
       job_command(named("sky", "Compute sky-view factors of points or of the ground"), jobs::add_sky_fields),
       job_command(named("sun", "Compute hours of direct sun on points, on the ground or at positions"),
                   jobs::add_sun_fields),
       job_command(named("lines", "Test lines of sight between pairs of positions"), jobs::add_lines_fields),
       job_command(named("summary", "Summarize what each observer sees in one row"),
                   jobs::add_summary_fields)}};
}

}  // namespace alidade::tools
