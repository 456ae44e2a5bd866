// SPDX-License-Identifier: MIT
#include "tools/command.h"
#include "extensions/placement/job.h"

namespace alidade::extensions {
namespace {

using namespace tools;

/// ExitCode::no if no candidate sees a target.
ExitCode code_of(const jobs::PlacePlan&, const jobs::PlaceResult& result) {
  return result.placement.positions.empty() ? ExitCode::no : ExitCode::done;
}

Command declare_place(const Options& visibility) {
  return job_command(visibility.command("place", "Choose the few observer positions that see most"),
                     jobs::add_place_fields, code_of);
}

}  // namespace

void add_placement(ProgramHooks& hooks) {
  hooks.commands.push_back({"visibility", declare_place});
}

}  // namespace alidade::extensions
