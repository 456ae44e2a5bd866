// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <vector>

#include "cloud/crs.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/long_run.h"
#include "jobs/plan.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/observers.h"
#include "visibility/points/summary.h"

namespace alidade::jobs {

/// A row of numbers for each observer.
struct SummaryRequest : VisibilityRequest {
  ObserverRequest observers;
  visibility::SummaryOptions summary;  ///< without classes
  CheckpointRequest checkpoint;
};

/// Declares all fields.
void add_summary_fields(const Fields& fields, SummaryRequest& request);

/// A checked request.
using SummaryPlan = Plan<SummaryRequest>;

/// Checks all that can be checked before a point is read. Errors: a step that does not divide 360; unknown
/// output format; no observers; files that cannot be read, replaced or written.
SummaryPlan plan(const SummaryRequest& request);

/// The observers, in the cloud's reference system, and as many summaries.
struct SummaryResult {
  std::vector<visibility::Observer> observers;
  Crs crs;
  std::vector<visibility::ObserverSummary> summaries;
  std::bitset<256> classes;  ///< of the cloud's points, for visibility::summary_row()
};

/// Summarizes what the observers see, and writes it where the request has an output. Errors: those of
/// load_cloud_alone(), load_observers() and visibility::summarize(); Cancelled. Memory: the cloud, its
/// surfaces, and that of visibility::summarize().
SummaryResult run(const SummaryPlan& plan, Listener& listener);

}  // namespace alidade::jobs
