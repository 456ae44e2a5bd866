// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "cloud/crs.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/long_run.h"
#include "jobs/plan.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/visibility_cloud.h"
#include "jobs/write_points.h"
#include "visibility/observers.h"
#include "visibility/points/point_visibility.h"

namespace alidade::jobs {

/// Whether the points that block sight are reported.
enum class BlockerColumns { none, all };

/// Which points observers see, and what blocks them.
struct PointsRequest : VisibilityRequest {
  ObserverRequest observers;
  CheckpointRequest checkpoint;
  int sub_rays = 1;
  std::optional<BlockerColumns> blockers;  ///< empty: those of a single observer
  std::filesystem::path lists;             ///< empty: none
};

/// Declares all fields.
void add_points_fields(const Fields& fields, PointsRequest& request);

/// A checked request.
using PointsPlan = Plan<PointsRequest>;

/// Checks all that can be checked before a point is read. Errors: unknown output format; no observers; files
/// that cannot be read, replaced or written.
PointsPlan plan(const PointsRequest& request);

/// What was found, and the observers in the cloud's reference system.
struct PointsResult {
  std::vector<visibility::Observer> observers;
  Crs crs;
  visibility::PointVisibility seen;
};

/// The columns that the output has beside those of the cloud. `seen` must outlive them.
std::vector<ResultColumn> columns_of(const visibility::PointVisibility& seen);

/// Computes what the observers see, and writes the points with it where the request has an output. Errors:
/// those of load_cloud_alone(), load_observers(), visibility::point_visibility() and write_points(); too many
/// observers for columns of blockers, or for VisibleBy in PLY; Cancelled. Memory: the cloud, its surfaces,
/// and that of visibility::check_point_visibility().
PointsResult run(const PointsPlan& plan, Listener& listener);

}  // namespace alidade::jobs
