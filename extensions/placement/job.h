// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "cloud/crs.h"
#include "extensions/placement/placement.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/long_run.h"
#include "jobs/plan.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/observers.h"

namespace alidade::jobs {

/// The few of many positions that together see most.
struct PlaceRequest : VisibilityRequest {
  ObserverRequest candidates;
  std::optional<double> target_height;
  double target_spacing = 1.0;
  std::optional<std::bitset<256>> target_classes;  ///< empty: all that block sight
  std::map<int, double> class_weights;             ///< 1 for the other classes
  std::size_t count = 0;                           ///< of positions
  CheckpointRequest checkpoint;
  std::filesystem::path curve;  ///< empty: none
};

/// Declares all fields.
void add_place_fields(const Fields& fields, PlaceRequest& request);

/// A checked request.
using PlacePlan = Plan<PlaceRequest>;

/// Checks all that can be checked before a point is read, except for the candidates. Errors: unknown output
/// format; files that cannot be read, replaced or written.
PlacePlan plan(const PlaceRequest& request);

/// The candidates, in the cloud's reference system, and those that were chosen of them: none if no candidate
/// sees a target whose weight is above 0.
struct PlaceResult {
  std::vector<visibility::Observer> candidates;
  Crs crs;
  std::vector<visibility::PlacementTarget> targets;
  visibility::Placement placement;
};

/// Chooses the positions, and writes them if there are any and the request has an output. Errors: those of
/// load_cloud_alone(), load_observers(), visibility::thin_points() and visibility::see_targets(); no
/// classes, or no points of those of the targets; Cancelled. Memory: the cloud, its surfaces, and a bit per
/// candidate and target.
PlaceResult run(const PlacePlan& plan, Listener& listener);

}  // namespace alidade::jobs
