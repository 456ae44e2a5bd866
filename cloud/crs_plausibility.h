// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "base/bounds.h"
#include "cloud/crs.h"

namespace alidade {

/// Whether the system's horizontal coordinates are longitude and latitude: WKT of a geographic system (also
/// as part of a compound one), or, without WKT, a GeoTIFF model type of 2; without a model type, keys that
/// name a geographic system and no projected one. False for whatever cannot be told.
bool is_geographic(const Crs& crs);

/// Whether the system's origin is the centre of the Earth: WKT of a geocentric system or, without WKT, a
/// GeoTIFF model type of 3.
bool is_geocentric(const Crs& crs);

/// A sentence if the points cannot lie in the system. Longitude and latitude: horizontal coordinates beyond
/// 400 (a full circle in gradians, the widest unit of angle in use) are no angles. Geocentric: the middle of
/// the points is 6300 to 6500 km from the centre of the Earth, whose radius is 6357 to 6378 km. Empty bounds
/// are never wrong.
std::optional<std::string> implausible_crs(const Crs& crs, const Bounds& bounds);

}  // namespace alidade
