// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <string_view>
#include <vector>

#include "base/input_file.h"
#include "geo/vector_file.h"
#include "visibility/objects.h"
#include "visibility/observers.h"

namespace alidade::visibility {

/// A number of an observer that files may hold.
struct ObserverField {
  std::string_view name;
  std::string_view short_name;  ///< fits the ten characters that Shapefiles have
  std::optional<double> GivenObserver::*value;

  bool is_called(std::string_view word) const { return word == name || word == short_name; }
};

/// All numbers but x and y.
constexpr std::array<ObserverField, 7> k_observer_fields{{
    {"z", "z", &GivenObserver::z},
    {"height", "height", &GivenObserver::height},
    {"azimuth_min", "azim_min", &GivenObserver::azimuth_min},
    {"azimuth_max", "azim_max", &GivenObserver::azimuth_max},
    {"elevation_min", "elev_min", &GivenObserver::elevation_min},
    {"elevation_max", "elev_max", &GivenObserver::elevation_max},
    {"max_distance", "max_dist", &GivenObserver::max_distance},
}};

/// Reads observers from CSV: a header with the names of the columns in any order, then a row each. `x` and
/// `y` must be there; `z`, `name`, `height`, `azimuth_min`, `azimuth_max`, `elevation_min`, `elevation_max`
/// and `max_distance` may, also under the short names of k_observer_fields. An empty cell counts as missing;
/// blank lines are skipped. Errors, naming line and column: an unknown or repeated name, a missing
/// position, a cell that is not a number, too many or too few cells; no row at all.
std::vector<GivenObserver> read_observer_table(const std::filesystem::path& path);
std::vector<GivenObserver> read_observer_table(InputFile& file);

/// Transforms positions from the reference system `own`, WKT, empty if the file has none, to the cloud's. z
/// and heights remain as they are, in the cloud's unit. Positions remain as they are if both systems are
/// the same or both are unknown. Errors: only one is unknown; one that GDAL does not understand; a position
/// that cannot be transformed.
void to_cloud_reference(std::vector<GivenObserver>& observers, const std::string& own,
                        const geo::ObserverReference& reference);

/// Reads observers from a file, in the cloud's reference system: CSV (read_observer_table()) if the
/// extension is .csv or .txt, anything else as points of GeoJSON, GeoPackage or Shapefile. Attributes with
/// the names of k_observer_fields and `name`, in upper or lower case, are read; others are ignored. The foot
/// of a point with z, or with an attribute z, is there; that of others is on the ground. Each point of a
/// multi-point is an observer. CSV, which names no reference system, is in the cloud's. Errors: not such a
/// file, damaged, no features, more than one layer; other geometries than points; an attribute that is not a
/// number; those of to_cloud_reference().
std::vector<GivenObserver> read_observers(const std::filesystem::path& path,
                                          const geo::ObserverReference& reference);

/// Reads objects from a file, in the cloud's reference system: CSV as read_observer_table() has it, with a
/// vertical segment in each row; else points, lines and polygons of GeoJSON, GeoPackage or Shapefile with the
/// attributes `height`, `z` of the foot and `name`. The foot of a vertex with z is there. Each point of a
/// multi-point is an object; the lines or polygons of a feature are one. Inner rings are ignored. Errors:
/// those of read_observers() and to_cloud_reference(); other geometries than these.
GivenObjects read_objects(const std::filesystem::path& path, const geo::ObserverReference& reference);

}  // namespace alidade::visibility
