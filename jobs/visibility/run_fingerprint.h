// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "base/fingerprint.h"
#include "geo/raster.h"
#include "jobs/long_run.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/observers.h"

namespace alidade::jobs {

/// All that the answers of a job depend on: its name, the fields given to it without those that cannot change
/// answers (outputs, threads, messages), the points, surfaces, classes and reference system of the cloud as
/// it was loaded; and the observers where they were placed. Requires that the fields were read. Cost: the
/// cloud is read once.
Fingerprint run_fingerprint(const CheckpointRequest& request, const VisibilityCloud& cloud);
Fingerprint run_fingerprint(const CheckpointRequest& request, const VisibilityCloud& cloud,
                            std::span<const visibility::Observer> observers);

/// Adds the cells of a map.
void add_to_fingerprint(const geo::RasterGrid& grid, Fingerprint& fingerprint);

/// Adds other numbers, which messages call `name`.
void add_to_fingerprint(const std::string& name, std::span<const double> numbers, Fingerprint& fingerprint);

/// A run whose answers depend on run_fingerprint() of the cloud and the observers.
struct VisibilityRun : LongRun {
  VisibilityRun(const CheckpointRequest& request, const VisibilityCloud& cloud,
                std::span<const visibility::Observer> observers, Listener& listener)
      : LongRun(
            request, [&] { return run_fingerprint(request, cloud, observers); }, listener) {}
};

}  // namespace alidade::jobs
