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

/// What take() of read_vector_file() is given, while it runs.
class VectorFeature {
 public:
  explicit VectorFeature(void* feature) : feature_(feature) {}

  long long id() const;
  /// The points of a Point or a MultiPoint; empty for every other geometry.
  std::optional<std::vector<VectorPoint>> points() const;
  /// "Polygon", or "no geometry".
  std::string geometry_type() const;
  /// The field of that name, whatever the case of its characters; empty if the layer has none.
  std::optional<VectorField> field(std::string_view name) const;

 private:
  void* feature_;  ///< OGRFeatureH
};

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
