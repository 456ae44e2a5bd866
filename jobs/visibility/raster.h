// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cloud/crs.h"
#include "geo/raster.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/long_run.h"
#include "jobs/plan.h"
#include "jobs/visibility/map_request.h"
#include "jobs/visibility/observer_request.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/observers.h"
#include "visibility/raster/viewshed.h"
#include "visibility/raster/viewshed_file.h"

namespace alidade::jobs {

/// The program whose defaults apply.
enum class DefaultSet { gdal, grass };

/// Objects whose visibility a map shows.
struct ObjectRequest {
  std::vector<visibility::GivenObserver> segments;  ///< --object
  std::filesystem::path file;                       ///< --objects; empty: none
  std::string reference;                            ///< --objects-crs
  std::optional<double> spacing, width;             ///< --object-spacing, --object-width

  bool any() const { return !segments.empty() || !file.empty(); }
  /// Name of the first field that was given; empty: none.
  std::string given() const;
};

/// A map of what is visible from observers, or of objects.
struct RasterRequest : VisibilityRequest {
  ObserverRequest observers;
  ObjectRequest objects;
  MapRequest map;
  CheckpointRequest checkpoint;
  DefaultSet like = DefaultSet::gdal;
  std::optional<visibility::ViewshedMode> given_mode;
  std::optional<double> curvature;
  std::optional<double> highest;
  std::optional<int> positions_across;
  std::optional<std::uint8_t> visible_value, invisible_value, out_of_range_value;

  visibility::ViewshedMode mode() const {
    return given_mode.value_or(objects.any() ? visibility::ViewshedMode::fraction
                                             : visibility::ViewshedMode::visible);
  }
};

/// Declares all fields.
void add_raster_fields(const Fields& fields, RasterRequest& request);

/// A checked request.
using RasterPlan = Plan<RasterRequest>;

/// Checks all that can be checked before a point is read. Errors: fields that do not apply to the map or
/// exclude each other; no observers and no objects; files that cannot be read, replaced or written.
RasterPlan plan(const RasterRequest& request);

/// A map as it was written.
struct RasterResult {
  geo::RasterGrid grid;
  Crs crs;
  visibility::ViewshedBand band;
  MapMetadata metadata;
};

/// Computes the map, and writes it where the request has an output. Errors: those of load_cloud_alone(),
/// load_observers(), find_map_ground() and visibility::viewshed(); no objects of a width for solid angles;
/// Cancelled. Memory: the cloud, its surfaces, and some 30 bytes per cell.
RasterResult run(const RasterPlan& plan, Listener& listener);

}  // namespace alidade::jobs
