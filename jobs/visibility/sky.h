// SPDX-License-Identifier: MIT
#pragma once

#include <variant>
#include <vector>

#include "cloud/crs.h"
#include "geo/raster.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "jobs/visibility/map_request.h"
#include "jobs/visibility/sky_site.h"
#include "jobs/write_points.h"

namespace alidade::jobs {

/// Sky-view factors of points or of the ground.
struct SkyRequest : SkySiteRequest {
  int directions = 128;
};

/// Declares all fields.
void add_sky_fields(const Fields& fields, SkyRequest& request);

/// A checked request.
using SkyPlan = Plan<SkyRequest>;

/// Checks all that can be checked before a point is read. Errors: those of plan_sky_site().
SkyPlan plan(const SkyRequest& request);

/// Sky-view factors.
struct SkyResult {
  /// By point id, or of the cells, k_no_float without ground.
  std::variant<std::vector<float>, geo::Raster<float>> views;
  Crs crs;
  MapMetadata metadata;  ///< of a map
};

/// The column of points that the output has beside those of the cloud. `views` must outlive it.
std::vector<ResultColumn> columns_of(const std::vector<float>& views);

/// Computes the factors, and writes them where the request has an output. Errors: those of load_sky_site(),
/// point_sky_views() or ground_sky_views() of visibility/sky/sky_of_cloud.h, and write_points(); Cancelled.
/// Memory: the cloud, its surfaces, and that of the library's functions.
SkyResult run(const SkyPlan& plan, Listener& listener);

}  // namespace alidade::jobs
