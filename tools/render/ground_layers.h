// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cloud/cloud_inputs.h"
#include "renderer/render.h"
#include "tools/render/empty_views.h"

namespace alidade::tools {

/// What an orthophoto shows beside colours, cell by cell.
enum class GroundLayer {
  elevation,       ///< z of the surface that is seen from above
  intensity,       ///< of the point whose surface that is
  classification,  ///< likewise
  density,         ///< points per square unit of the map, at any height
  count,           ///< points, at any height
};

/// Their names, in the order of the enum.
inline constexpr const char* k_ground_layers[] = {"elevation", "intensity", "classification", "density",
                                                  "count"};

/// What is requested of an orthophoto: any of them, and whether its colours.
struct GroundLayers {
  std::vector<GroundLayer> layers;
  bool with_color = true;

  /// The raster of each: the output itself for one without colours, else "site_elevation.tif" for site.tif.
  std::vector<std::filesystem::path> files(const std::filesystem::path& output) const;
};

/// Writes them as cloud-optimised GeoTIFFs (geo/raster_file.h) of the view, an orthophoto's: elevations and
/// densities as float, with NaN where nothing is seen, intensities as uint16 with 0, classes as uint8 with 255,
/// counts as uint32. `empty` gets the view if it sees no point; warns of attributes that all points have alike. Reads
/// the attributes of the clouds again. Errors: the cloud lacks an attribute; those of write_raster().
void write_ground_layers(const GroundLayers& wanted, const renderer::Scene& scene,
                         const renderer::LoadedCloud& cloud, const CloudInputs& clouds, const View& view,
                         const std::filesystem::path& output, bool overwrite, EmptyViews& empty,
                         Verbosity verbosity);

}  // namespace alidade::tools
