// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "cloud/select_points.h"
#include "geo/vector_file.h"

namespace alidade::geo {

/// Reads the polygons of a GeoJSON, GeoPackage or Shapefile, in the cloud's reference system: those of all
/// features, also multi-polygons and collections of such, arcs as short chords. Heights are passed over. It
/// is the corners that are transformed: the edges between them are straight in the cloud's system. Errors:
/// not such a file, damaged, more than one layer; other geometries than polygons, or none; coordinates that
/// are no numbers; transformation_to_cloud().
std::vector<PlanePolygon> read_polygons(const std::filesystem::path& path,
                                        const ObserverReference& reference);

}  // namespace alidade::geo
