// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "cloud/crs.h"

namespace alidade::geo {

// The functions of a CrsLibrary, by GDAL and PROJ.

/// All of a system as WKT: that of the file, or that of its GeoTIFF keys, with their heights. Where a key
/// states the unit of heights, it overrides that of the vertical system's code: programs write both, and mean
/// the unit. Empty if it is missing or invalid.
std::string library_wkt(const Crs& crs);

/// Whether two systems are one, whatever their names, the order of their axes and how they are written.
/// `different`: x and y differ; or the unit of heights does, where one that is not stated is that of x and y;
/// or the datums of heights do, if both are stated. `unknown`: equal numbers on datums without a code, or one
/// system without a relation to the Earth. Empty if GDAL does not understand one of them.
std::optional<CrsAgreement> compare_systems(const Crs& a, const Crs& b);

}  // namespace alidade::geo
