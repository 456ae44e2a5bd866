// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "base/fingerprint.h"
#include "geo/raster.h"
#include "jobs/fields.h"
#include "jobs/listener.h"
#include "jobs/long_run.h"
#include "jobs/visibility/map_request.h"
#include "jobs/visibility/visibility_cloud.h"
#include "visibility/raster/ground.h"
#include "visibility/raster/map_image.h"
#include "visibility/sky/sky_view.h"

// What the jobs on sky and sun share: numbers for every point, or for every cell of the ground.

namespace alidade::jobs {

/// What both are requested with. Without an output nothing but what other fields name is written.
struct SkySiteRequest : VisibilityRequest {
  std::optional<visibility::SkyReceiver> receiver;  ///< empty: surfaces of points, horizontal cells
  MapRequest map;                                   ///< maps only
  CheckpointRequest checkpoint;
  double max_distance = std::numeric_limits<double>::infinity();

  /// Whether the answers are for cells: by the extension of the output; without one, if a field of maps is
  /// given.
  bool is_map() const;
};

/// Declares the fields of both but those of the cloud.
void add_sky_site_fields(const Fields& fields, SkySiteRequest& request);

/// What is read, `reads` too, and written. Errors that need no cloud: an output of another format, or that
/// cannot be written; fields that do not apply to this kind of output; those of check_checkpoint().
PlannedWork plan_sky_site(const SkySiteRequest& request,
                          std::initializer_list<std::filesystem::path> reads = {});

/// A cloud, and if a map is requested, its ground and cells.
struct SkySite {
  std::unique_ptr<VisibilityCloud> cloud;
  std::optional<visibility::Ground> ground;
  geo::RasterGrid grid;
  std::string unit;  ///< of the cells: "m", "ft" or empty
};

/// All that is done before occluders are measured, which may take long. `bands`: of a map. Requires: checked
/// by plan_sky_site(). Errors: those of load_cloud_alone(), map_grid().
SkySite load_sky_site(const SkySiteRequest& request, int bands, Listener& listener);

/// All that the answers of both jobs depend on.
Fingerprint sky_fingerprint(const SkySiteRequest& request, const SkySite& site);

/// A band of a map; NaN where there is no value, which is written as k_no_float.
struct SkyBand {
  geo::Raster<float>& values;
  std::string description, unit;
};

/// Writes a map as GeoTIFF if there is an output, and the image of its first band if one is requested.
/// `metadata`: beside that of all maps. `image`: without values and unit. Replaces NaN in the bands by
/// k_no_float. Returns the metadata of the map.
MapMetadata write_sky_map(const SkySiteRequest& request, const SkySite& site, std::span<const SkyBand> bands,
                          const MapMetadata& metadata, visibility::MapImage image);

/// "0.02 to 0.97, mean 0.61": of the values that are numbers.
std::string range_and_mean(const std::function<float(std::size_t)>& value, std::size_t count);

}  // namespace alidade::jobs
