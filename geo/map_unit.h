// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "cloud/crs.h"

namespace alidade::geo {

/// Unit of z by the coordinate reference system: "m", "ft", or empty where it names another or none. The
/// vertical system counts, else the unit of the horizontal one; heights over degrees are metres, and so are
/// those of a cloud without any system.
std::string height_unit(const Crs& crs);

/// The unit of a map's coordinates.
enum class MapUnit {
  unknown,  ///< the cloud has no reference system, or one that does not state it
  metre,
  foot,
  degree,  ///< no lengths can be measured over them
};

/// The unit of x and y, by axis_units(); heights of a compound system may have another. Codes are resolved
/// only where a CrsLibrary is used.
MapUnit map_unit(const Crs& crs);

/// "m", "ft", "deg" or "unknown".
const char* unit_name(MapUnit unit);

/// Metres of a unit; of an unknown one 1. Requires: not degrees.
double metres_per_unit(MapUnit unit);

}  // namespace alidade::geo
