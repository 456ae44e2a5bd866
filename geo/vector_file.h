// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cloud/crs.h"
#include "cloud/select_points.h"

namespace alidade::geo {

/// The purpose of a vector file, for messages.
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

/// One field of a feature.
struct VectorField {
  bool is_set = false;             ///< neither absent nor null
  std::optional<double> number{};  ///< if the field is of a type of numbers
  std::string text{};
};

/// A point of a feature, in the reference system of its layer.
struct VectorPoint {
  glm::dvec2 position{0.0};  ///< not finite if the point is empty
  std::optional<double> z{};
};

/// A line string, or a ring of a polygon, of a feature; in the reference system of its layer.
struct VectorPath {
  std::vector<VectorPoint> points;  ///< those of a ring without its last, which is its first again
  bool is_ring = false;
  bool is_hole = false;  ///< an inner ring
};

/// The feature that read_vector_file() passes to take(), valid while that runs.
class VectorFeature {
 public:
  explicit VectorFeature(void* feature) : feature_(feature) {}

  long long id() const;
  /// The points of a Point or a MultiPoint; empty for every other geometry.
  std::optional<std::vector<VectorPoint>> points() const;
  /// The paths of line strings and polygons, also of several and of collections of such, arcs as short
  /// chords; empty for every other geometry.
  std::optional<std::vector<VectorPath>> paths() const;
  /// "Polygon", or "no geometry".
  std::string geometry_type() const;
  /// The field of that name, ignoring case; empty if the layer has none.
  std::optional<VectorField> field(std::string_view name) const;

 private:
  void* feature_;  ///< OGRFeatureH
};

/// The reference system of observers, or of other features, and the one to transform them to.
struct ObserverReference {
  /// The user's, overriding that of a file: any text that GDAL understands ("EPSG:4326", WKT, PROJ), x east
  /// and y north whatever its axes; "cloud" for the cloud's own. Empty: that of the file.
  std::string given{};
  Crs cloud{};
  std::string option = "--observers-crs";  ///< the option that states it, for messages
  std::string whose = "observers";         ///< in messages
};

/// Transforms a position to the cloud's reference system. Errors, which name `source`: it has no image there.
using MoveToCloud = std::function<glm::dvec2(const glm::dvec2& position, const std::string& source)>;

/// From a file's reference system, `own` (WKT, empty if the file has none), to the cloud's; empty if
/// positions stay as they are, because the systems are equal or both missing. Errors, which name `source`:
/// only one system is given; GDAL does not understand one; there is no transformation.
MoveToCloud move_to_cloud(const std::string& own, const ObserverReference& reference,
                          const std::string& source);

/// Reads the polygons of a GeoJSON, GeoPackage or Shapefile, in the cloud's reference system: those of all
/// features, also multi-polygons and collections of such, arcs as short chords. Heights are ignored. The
/// corners are transformed: the edges between them are straight in the cloud's system. Errors:
/// not such a file, damaged, more than one layer; other geometries than polygons, or none; coordinates that
/// are no numbers; those of move_to_cloud().
std::vector<PlanePolygon> read_polygons(const std::filesystem::path& path,
                                        const ObserverReference& reference);

}  // namespace alidade::geo
