// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "base/exact_math.h"
#include "cloud/crs.h"

namespace alidade::geo {

/// Radius of the spherical Earth, metres.
constexpr double k_earth_radius = 6'371'000.0;

/// Unit vector towards an azimuth (degrees clockwise from north, +y) and an elevation (degrees above the
/// horizontal). The same bits on every machine.
inline glm::dvec3 compass_direction(double azimuth, double elevation) {
  const SineCosine turn = sine_cosine_of_degrees(azimuth), rise = sine_cosine_of_degrees(elevation);
  return {turn.sine * rise.cosine, turn.cosine * rise.cosine, rise.sine};
}

/// Where on Earth a position of a map lies, and how the map is turned there.
struct GroundPosition {
  double latitude = 0.0, longitude = 0.0;  ///< degrees, WGS 84
  /// Azimuth of the map's +y, degrees clockwise from true north, in (-180, 180]: the meridian convergence.
  double grid_north = 0.0;
};

/// The position (x, y) in a reference system. Empty if the system is not known, lies nowhere on Earth (local,
/// geocentric), or has no such position. The convergence is taken from the positions 0.0001 degrees (11 m)
/// north and south, through PROJ, so it holds for every projection; it is good to 0.00001 degrees. For
/// geographic systems x is the longitude and it is 0.
std::optional<GroundPosition> ground_position(const Crs& crs, const glm::dvec2& position);

/// Longitude and latitude (degrees, WGS 84) of positions in a reference system; z stays as it is. Rounded to
/// 1e-9 degrees (0.1 mm), so that every machine answers the same. Empty if the system is not known or lies
/// nowhere on Earth, or if one of the positions does.
std::optional<std::vector<glm::dvec3>> lon_lat(const Crs& crs, std::span<const glm::dvec3> positions);

/// Length of a map's unit. Of a cloud that names no system, which is taken for metres, 1; empty for degrees
/// and for systems that GDAL does not know.
std::optional<double> metres_per_unit(const Crs& crs);

}  // namespace alidade::geo
