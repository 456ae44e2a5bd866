// SPDX-License-Identifier: MIT
#include "jobs/visibility/photos.h"

#include <algorithm>

#include "tools/command.h"

namespace alidade::tools {
namespace {

/// ExitCode::no if no photo sees a point.
ExitCode photos_code(const jobs::PhotosPlan&, const jobs::PhotosResult& result) {
  const auto sees = [](const visibility::PhotoSummary& photo) { return photo.points > 0; };
  return std::ranges::any_of(result.seen.photos, sees) ? ExitCode::done : ExitCode::no;
}

}  // namespace

Command add_visibility_photos(const Options& visibility) {
  const Options photos = visibility.command(
      "photos", "Compute which photos see which points, their footprints, and colours of points");
  auto command = std::make_shared<JobCommand<jobs::PhotosRequest>>();
  add_cloud(photos, command->request.files, {"--ignore-classes"});
  jobs::add_photos_fields(photos, command->request);
  add_run_options(photos, command->request.partial, command->request.threads, command->verbosity);
  return job_command(photos, command, photos_code);
}

}  // namespace alidade::tools
