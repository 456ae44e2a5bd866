// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "jobs/write_points.h"
#include "tools/options.h"
#include "tools/visibility/visibility_request.h"
#include "visibility/raster/ground.h"
#include "visibility/raster/map_image.h"
#include "visibility/sky/sky_view.h"

// What `visibility sky` and `visibility sun` share: numbers for every point, or for every cell of the ground.

namespace alidade::tools {

/// Options of both commands.
struct SkyRequest : VisibilityRequest {
  std::optional<visibility::SkyReceiver> receiver;  ///< empty: surfaces of points, horizontal cells
  MapRequest map;                                   ///< maps only
  CheckpointRequest checkpoint;
  double max_distance = std::numeric_limits<double>::infinity();

  /// Whether the answers are for cells, by the extension of the output.
  bool is_map() const;
};

/// Declares the options of both commands.
void add_sky_request(const Fields& command, SkyRequest& request);

/// A cloud, and if a map is requested, its ground and cells.
struct SkySite {
  std::unique_ptr<VisibilityCloud> cloud;
  std::optional<visibility::Ground> ground;
  geo::RasterGrid grid;
  std::string unit;  ///< of the cells: "m", "ft" or empty
};

/// All that is done before occluders are measured, which may take long. `bands`: of a map. Errors: an output
/// of another format, or that cannot be written; options that do not apply to this kind of output; the module
/// that writes the output is missing; those of load_cloud_alone(), map_grid().
SkySite load_sky_site(const SkyRequest& request, int bands, Console& console);

/// All that the answers of both commands depend on.
Fingerprint sky_fingerprint(const SkyRequest& request, const SkySite& site);

/// A band of a map; NaN where there is no value, which is written as k_no_float.
struct SkyBand {
  geo::Raster<float>& values;
  std::string description, unit;
};

/// Writes a map as GeoTIFF, and the image of its first band if one is requested. `metadata`: beside that of
/// all maps. `image`: without values and unit. Replaces NaN in the bands by k_no_float.
void write_sky_map(const SkyRequest& request, const SkySite& site, std::span<const SkyBand> bands,
                   const MapMetadata& metadata, visibility::MapImage image);

/// "0.02 to 0.97, mean 0.61": of the values that are numbers.
std::string range_and_mean(const std::function<float(std::size_t)>& value, std::size_t count);

}  // namespace alidade::tools
