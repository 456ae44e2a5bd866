// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "base/words.h"
#include "cloud/crs.h"
#include "cloud/select_points.h"

// Vector layers that GIS programs open.
//
//   geo::write_geopackage("site.gpkg",
//                         {{.name = "paths", .columns = {{"name", ColumnType::text}}, .features = ...}},
//                         cloud.crs, false);

namespace alidade::geo {

enum class ColumnType { whole_number, number, text };

/// A value of its column's type; null for a monostate.
using VectorValue = std::variant<std::monostate, std::int64_t, double, std::string>;

/// Polygons, the first ring of each its outline and the others its holes; or the corners of a line, with z.
using VectorShape = std::variant<std::vector<PlanePolygon>, std::vector<glm::dvec3>>;

/// One row of a layer.
struct LayerFeature {
  VectorShape shape;                ///< of the layer's kind; without polygons or corners: no geometry
  std::vector<VectorValue> values;  ///< one per column
};

enum class LayerShape { polygons, lines };

/// A layer to write.
struct VectorLayer {
  std::string name;
  std::string description;
  LayerShape shape = LayerShape::polygons;  ///< multi-polygons, or line strings with z
  std::vector<std::pair<std::string, ColumnType>> columns;
  std::vector<LayerFeature> features;
};

/// Writes a GeoPackage (OGC 12-128) with these layers, x and y in the reference system of a cloud; one that
/// GDAL does not support, or without a relation to the Earth, is left out. The file appears completely or not
/// at all. Equal layers give equal bytes with one version of GDAL: the date of the last change in it is that
/// of the format's first version, 2014-02-10. Errors: the name does not end in .gpkg; an existing file
/// without `overwrite`; a full disk and other write failures. Memory: the encoded file.
void write_geopackage(const std::filesystem::path& file, const std::vector<VectorLayer>& layers,
                      const Crs& crs, bool overwrite);

/// Errors: the name does not end in .gpkg.
inline void check_geopackage_name(const std::filesystem::path& file) {
  if (!has_extension(file, {".gpkg"})) throw file_error(file, "unknown output format", "the extension .gpkg");
}

}  // namespace alidade::geo
