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

/// A number that files can say of an observer.
struct ObserverField {
  std::string_view name;
  std::string_view short_name;  ///< fits the ten characters that Shapefiles have
  std::optional<double> GivenObserver::*value;

  bool is_called(std::string_view word) const { return word == name || word == short_name; }
};

/// All but the position; a name is a text of its own.
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
/// and `max_distance` may, also under the short names of observer_fields.h. An empty cell is as if it were
/// not there; blank lines are skipped. Errors, naming line and column: an unknown or repeated name, a missing
/// position, a cell that is not a number, too many or too few cells; no row at all.
std::vector<GivenObserver> read_observer_table(const std::filesystem::path& path);
std::vector<GivenObserver> read_observer_table(InputFile& file);

/// Turns positions into the cloud's reference system: those in `own`, WKT, empty if the file says nothing. z
/// and heights stay as they are, in the cloud's unit. Positions are untouched if both systems are the same,
/// or none is known. Errors: one is known and the other not; one that GDAL does not understand; a position
/// that has no image.
void to_cloud_reference(std::vector<GivenObserver>& observers, const std::string& own,
                        const geo::ObserverReference& reference);

/// Reads observers from a file, in the cloud's reference system: CSV (observer_table.h) by its extension .csv
/// or .txt, anything else as points of GeoJSON, GeoPackage or Shapefile. Attributes of the names of
/// observer_fields.h and `name` are taken, in any case of characters; others are passed over. A point with z,
/// or with an attribute z, has its foot there; others are on the ground. A multi-point is as many observers.
/// CSV, which names no reference system, is in the cloud's. Errors: not such a file, damaged, no features,
/// more than one layer; other geometries than points; an attribute that is not a number;
/// to_cloud_reference().
std::vector<GivenObserver> read_observers(const std::filesystem::path& path,
                                          const geo::ObserverReference& reference);

/// Reads objects from a file, in the cloud's reference system: CSV as read_observer_table() has it, with a
/// vertical segment in each row; else points, lines and polygons of GeoJSON, GeoPackage or Shapefile with the
/// attributes `height`, `z` of the foot and `name`. Vertices with a z have their foot there. Each point of a
/// multi-point is an object; the lines or polygons of a feature are one. Inner rings are passed over. Errors: those of
/// read_observers(), of other geometries than these.
GivenObjects read_objects(const std::filesystem::path& path, const geo::ObserverReference& reference);

}  // namespace alidade::visibility
