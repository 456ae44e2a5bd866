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
/// horizontal). Equal bits on every machine.
inline glm::dvec3 compass_direction(double azimuth, double elevation) {
  const SineCosine turn = sine_cosine_of_degrees(azimuth), rise = sine_cosine_of_degrees(elevation);
  return {turn.sine * rise.cosine, turn.cosine * rise.cosine, rise.sine};
}

/// Latitude and longitude of a position on a map, and how the map is turned there.
struct GroundPosition {
  double latitude = 0.0, longitude = 0.0;  ///< degrees, WGS 84
  /// Azimuth of the map's +y, degrees clockwise from true north, in (-180, 180]: the meridian convergence.
  double grid_north = 0.0;
};

/// The GroundPosition of (x, y) in a reference system. Empty if the system is unknown, local or geocentric,
/// or has no such position. The convergence comes from the positions 0.0001 degrees (11 m) north and south,
/// through PROJ, so it holds for every projection; it is good to 0.00001 degrees. For geographic systems x is
/// the longitude and the convergence 0.
std::optional<GroundPosition> ground_position(const Crs& crs, const glm::dvec2& position);

/// Longitude and latitude (degrees, WGS 84) of positions in a reference system; z stays as it is. Rounded to
/// 1e-9 degrees (0.1 mm), so that all machines give equal results. Empty if the system is unknown or has no
/// relation to the Earth, or if one of the positions has no image there.
std::optional<std::vector<glm::dvec3>> lon_lat(const Crs& crs, std::span<const glm::dvec3> positions);

/// Length of a map's unit. 1 for a cloud without a system, which is taken for metres; empty for degrees and
/// for systems that GDAL does not support.
std::optional<double> metres_per_unit(const Crs& crs);

}  // namespace alidade::geo
