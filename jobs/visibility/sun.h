// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/huge_memory.h"
#include "cloud/crs.h"
#include "geo/raster.h"
#include "jobs/listener.h"
#include "jobs/plan.h"
#include "jobs/visibility/map_request.h"
#include "jobs/visibility/sun_request.h"
#include "jobs/write_points.h"
#include "visibility/observers.h"
#include "visibility/row_text.h"

namespace alidade::jobs {

/// A checked request.
using SunPlan = Plan<SunRequest>;

/// Checks all that can be checked before a point is read. Errors: fields that exclude each other, or do not
/// apply to observers; those of check_given() or plan_sky_site().
SunPlan plan(const SunRequest& request);

/// What receivers get.
struct SunResult {
  std::vector<std::string> periods;     ///< their names; one without a name is the whole time
  std::optional<geo::RasterGrid> grid;  ///< of a map
  /// Of the first point, cell or observer, for each period, then of the next; sun_quantities() have their
  /// values. NaN in cells without ground.
  HugeVector<float> numbers;
  std::size_t per_period = 1;                   ///< number of numbers
  std::vector<visibility::Observer> observers;  ///< empty: of points or cells
  Crs crs;
  MapMetadata metadata;

  std::size_t receivers() const { return numbers.size() / (per_period * periods.size()); }
  const float* of(std::size_t receiver, std::size_t period) const {
    return &numbers[(receiver * periods.size() + period) * per_period];
  }
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

/// Computes what receivers get, and writes it where the request has an output. Errors: those of
/// load_sky_site() or load_observers(), sun_of() and the functions of visibility/sky/sky_of_cloud.h; a
/// diagram of several observers; Cancelled. Memory: the cloud, its surfaces, and that of the library's
/// functions.
SunResult run(const SunPlan& plan, Listener& listener);

}  // namespace alidade::jobs
