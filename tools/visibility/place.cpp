// SPDX-License-Identifier: MIT
#include "jobs/visibility/place.h"

#include "tools/command.h"

namespace alidade::tools {
namespace {

/// ExitCode::no if no candidate sees a target.
ExitCode place_code(const jobs::PlacePlan&, const jobs::PlaceResult& result) {
  return result.placement.positions.empty() ? ExitCode::no : ExitCode::done;
}

}  // namespace

Command add_visibility_place(const Options& visibility) {
  const Options place = visibility.command("place", "Choose the few observer positions that see most");
  auto command = std::make_shared<JobCommand<jobs::PlaceRequest>>();
  add_cloud(place, command->request.files, {"--ignore-classes"});
  jobs::add_place_fields(place, command->request);
  add_run_options(place, command->request.partial, command->request.threads, command->verbosity);
  return job_command(place, command, place_code);
}

}  // namespace alidade::tools
