// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "cloud/crs.h"

namespace alidade::geo {

// The functions of a CrsLibrary, by GDAL and PROJ.

/// All of a system as WKT: what the file gave, or what its GeoTIFF keys mean, with their heights. Where a key states
/// the unit of heights, it holds above that of the vertical system's code: programs write both, and mean the unit.
/// Empty if it is missing or invalid.
std::string whole_wkt(const Crs& crs);

/// Whether two systems are one, whatever their names, the order of their axes and how they are written. `different`:
/// x and y, or the unit of heights, where one that is not stated is that of x and y, or two heights that are both known
/// by their datum. `unknown`: the same numbers on datums that are not known by a code, or one system that lies nowhere
/// on Earth. Empty if GDAL does not understand one of them.
std::optional<CrsAgreement> compare_systems(const Crs& a, const Crs& b);

}  // namespace alidade::geo
