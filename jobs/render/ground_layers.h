// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "jobs/render/views.h"

namespace alidade::jobs {

/// Layers of an orthophoto beside its colours, one value per cell.
enum class GroundLayer {
  elevation,       ///< z of the surface that is seen from above
  intensity,       ///< of the point of that surface
  classification,  ///< likewise
  density,         ///< points per square unit of the map, at any height
  count,           ///< points, at any height
};

/// Their names, in the order of the enum.
inline constexpr const char* k_ground_layers[] = {"elevation", "intensity", "classification", "density",
                                                  "count"};

/// The requested layers of an orthophoto, and whether its colours are requested.
struct GroundLayers {
  std::vector<GroundLayer> layers;
  bool with_color = true;

  /// The raster of each: the output itself for one without colours, else "site_elevation.tif" for site.tif.
  std::vector<std::filesystem::path> files(const std::filesystem::path& output) const;
};

/// Writes the layers as cloud-optimised GeoTIFFs (geo/raster_file.h) of the view, an orthophoto's, into
/// files(scene.output.file): elevations and densities as float with nodata NaN, intensities as uint16 with
/// nodata 0, classes as uint8 with nodata 255, counts as uint32. `empty` gets the view if it sees no point;
/// warns of attributes with equal values for all points. Reads the attributes of the clouds again. Errors:
/// the cloud lacks an attribute; those of write_raster().
void write_ground_layers(const GroundLayers& wanted, const renderer::Scene& scene,
                         const renderer::LoadedCloud& cloud, const CloudInputs& clouds,
                         const camera::NamedCamera& view, bool overwrite, EmptyViews& empty,
                         Listener& listener);

}  // namespace alidade::jobs
