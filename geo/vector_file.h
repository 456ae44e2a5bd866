// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "cloud/crs.h"

namespace alidade::geo {

/// What a vector file is read as, for messages.
struct VectorContent {
  std::string content;   ///< "observers"
  std::string expected;  ///< formats and geometries
  std::string features;  ///< "points"
};

/// Calls take(feature), an OGRFeatureH, for every feature of the only layer of a GeoJSON, GeoPackage or
/// Shapefile; returns the layer's reference system as WKT, empty if it has none. Errors: no such file,
/// damaged, no layer or several; what `take` throws.
std::string read_vector_file(const std::filesystem::path& path, const VectorContent& content,
                             const std::function<void(void* feature)>& take);

/// Which reference system observers, or other things on the ground, are in, and which they are wanted in.
struct ObserverReference {
  /// What the user says, above what a file says: anything GDAL understands ("EPSG:4326", WKT, PROJ), x east
  /// and y north whatever its axes; "cloud" for the cloud's own. Empty: what the file says.
  std::string given{};
  Crs cloud{};
  std::string option = "--observers-crs";  ///< how the user says it, for messages
  std::string whose = "observers";         ///< what they are, for messages
};

}  // namespace alidade::geo
