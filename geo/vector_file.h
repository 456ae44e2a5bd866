// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace alidade {

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

}  // namespace alidade
