// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "cloud/crs.h"
#include "geo/raster.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "jobs/visibility/map_request.h"
#include "jobs/visibility/sun_request.h"
#include "jobs/write_points.h"
#include "visibility/observers.h"
#include "visibility/row_text.h"
#include "visibility/sky/sun_hours.h"

namespace alidade::jobs {

/// A checked request.
using SunPlan = Plan<SunRequest>;

/// Checks all that can be checked before a point is read. Errors: fields that exclude each other, or do not
/// apply to observers; those of check_given() or plan_sky_site().
SunPlan plan(const SunRequest& request);

/// What receivers get. Files hold the sun_quantities() of it.
struct SunResult {
  std::vector<std::string> periods;  ///< their names; one without a name is the whole time
  std::vector<geo::Raster<visibility::Radiation>> maps;  ///< for each period; NaN hours without ground
  /// Without maps: of the first point or observer, for each period, then of the next.
  std::vector<visibility::Radiation> radiation;
  std::vector<visibility::Observer> observers;  ///< empty: of points
  Crs crs;
  MapMetadata metadata;
};

/// A band of the map that is written, NaN without ground.
struct SunBand {
  std::string name, unit;
  geo::Raster<float> values;
};

/// The answers as the output has them: bands of a map; columns of points, which `result` must outlive; or a
/// row for each observer and period.
std::vector<SunBand> bands_of(const SunRequest& request, const SunResult& result);
std::vector<ResultColumn> columns_of(const SunRequest& request, const SunResult& result);
visibility::PositionTable table_of(const SunRequest& request, const SunResult& result);

/// Computes hours and radiation, and writes them where the request has an output. Errors: those of
/// load_sky_site() or load_observers(), sun_of() and the functions of visibility/sky/sun_hours.h and
/// sky_of_cloud.h; a diagram of several observers; Cancelled. Memory: the cloud, its surfaces, and that of
/// the library's functions.
SunResult run(const SunPlan& plan, Listener& listener);

}  // namespace alidade::jobs
