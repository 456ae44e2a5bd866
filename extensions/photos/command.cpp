// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>
#include <utility>

#include "base/error.h"
#include "extensions/photos/job.h"
#include "tools/command.h"

namespace alidade::extensions {
namespace {

using namespace tools;

/// ExitCode::no if no photo sees a point.
ExitCode code_of(const jobs::PhotosPlan&, const jobs::PhotosResult& result) {
  const auto sees = [](const visibility::PhotoSummary& photo) { return photo.points > 0; };
  return std::ranges::any_of(result.seen.photos, sees) ? ExitCode::done : ExitCode::no;
}

/// The command has no other answer than its files.
Command declare_photos(const Options& visibility) {
  const Options options = visibility.command(
      "photos", "Compute which photos see which points, their footprints, and colours of points");
  const auto command = std::make_shared<JobCommand<jobs::PhotosRequest>>();
  jobs::add_photos_fields(options, command->request);
  add_job_options(options, *command);
  Command job = job_command(options, command, code_of);
  job.run = [command, run = std::move(job.run)](const CommandLine& words) {
    if (command->request.output.empty() && command->request.footprints.empty())
      throw input_error("missing output", "-o FILE for points, --footprints FILE.gpkg, or both");
    return run(words);
  };
  return job;
}

}  // namespace

void add_photos(ProgramHooks& hooks) {
  hooks.commands.push_back({"visibility", declare_photos});
}

}  // namespace alidade::extensions
