// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "cloud/point_cloud.h"
#include "jobs/cloud_request.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"

namespace alidade::jobs {

/// A scan of the simulated site (simulation::courtyard()) as LAS, or LAZ by the extension of the output;
/// without an output the points are returned.
struct GenerateRequest : JobRequest {
  std::uint64_t point_count = 2'000'000, seed = 1;  ///< simulation::GenerateOptions
};

/// Declares all fields.
void add_generate_fields(const Fields& fields, GenerateRequest& request);

/// A checked request.
using GeneratePlan = Plan<GenerateRequest>;

/// Errors: an output of an unknown format, or that cannot be replaced or written.
GeneratePlan plan(const GenerateRequest& request);

/// Scans the site into the output, or else into the cloud that it returns. Errors: those of
/// simulation::generate_courtyard(). Cancelled.
PointCloud run(const GeneratePlan& plan, Listener& listener);

}  // namespace alidade::jobs
