// SPDX-License-Identifier: MIT
#pragma once

#include "jobs/load_cloud.h"
#include "jobs/visibility/long_run.h"
#include "jobs/visibility/map_request.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/visibility_cloud.h"
#include "tools/command.h"

// For the commands of `alidade visibility` that are no jobs yet.

namespace alidade::tools {

using namespace jobs;  // NOLINT(google-build-using-namespace): until these commands are jobs

/// What all of them are requested with.
struct VisibilityRequest : jobs::VisibilityRequest {
  Verbosity verbosity = Verbosity::normal;
  CommandLine words;  ///< of the program, filled by command_of() when it runs
};

}  // namespace alidade::tools
