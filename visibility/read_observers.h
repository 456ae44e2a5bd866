// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "geo/vector_file.h"
#include "visibility/observers.h"

namespace alidade {

/// Reads observers from a file, in the cloud's reference system: CSV (observer_table.h) by its ending .csv or
/// .txt, anything else as points of GeoJSON, GeoPackage or Shapefile. Attributes of the names of
/// observer_fields.h and `name` are taken, in any case of letters; others are passed over. A point with z, or
/// with an attribute z, has its foot there; others stand on the ground. A multi-point is as many observers.
/// CSV, which tells no reference system, is in the cloud's. Errors: not such a file, damaged, no features,
/// more than one layer; other geometries than points; an attribute that is no number; to_cloud_reference().
std::vector<GivenObserver> read_observers(const std::filesystem::path& path,
                                          const ObserverReference& reference);

}  // namespace alidade
