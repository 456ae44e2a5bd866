// SPDX-License-Identifier: MIT
// `alidade render` and `alidade merge`. Each runs a job.
#include "jobs/render/render.h"

#include "jobs/render/merge.h"
#include "tools/command.h"

namespace alidade::tools {
namespace {

/// ExitCode::no if a view sees no surface.
ExitCode render_code(const jobs::RenderPlan&, const jobs::RenderResult& result) {
  return result.empty_views.empty() ? ExitCode::done : ExitCode::no;
}

}  // namespace

Command add_render(const Options& program) {
  return job_command(program.command("render", "Render an image of a scene or of cloud files"),
                     jobs::add_render_fields, render_code);
}

Command add_merge(const Options& program) {
  const Options merge = program.command("merge", "Join the parts of an image that machines have rendered");
  const auto command = std::make_shared<JobCommand<jobs::MergeRequest>>();
  jobs::add_merge_fields(merge, command->request);
  add_verbosity(merge, command->verbosity);
  return job_command(merge, command, [](const jobs::MergePlan&, const renderer::MergedImage& merged) {
    return merged.film.sees_anything() ? ExitCode::done : ExitCode::no;
  });
}

}  // namespace alidade::tools
