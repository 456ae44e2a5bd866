// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <optional>

#include "cloud/crs.h"

namespace alidade {

/// Where on Earth a place of a map lies, and how the map is turned there.
struct GroundPlace {
  double latitude = 0.0, longitude = 0.0;  ///< degrees, WGS 84
  /// Azimuth of the map's +y, degrees clockwise from true north, in (-180, 180]: the meridian convergence.
  double grid_north = 0.0;
};

/// The place (x, y) in a reference system. Empty if the system is not known, lies nowhere on Earth (local,
/// geocentric), or has no such place. The convergence is taken from the places 0.0001 degrees (11 m) north
/// and south, through PROJ, so it holds for every projection; it is good to 0.00001 degrees. For geographic
/// systems x is the longitude and it is 0.
std::optional<GroundPlace> ground_place(const Crs& crs, const glm::dvec2& place);

}  // namespace alidade
