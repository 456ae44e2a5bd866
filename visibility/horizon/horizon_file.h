// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "visibility/horizon/horizon.h"

namespace alidade {

/// What a file says beside the line itself.
struct HorizonFacts {
  glm::dvec3 eye{0.0};
  std::optional<SkyShares> above_line;  ///< sky_above(); empty of a line that does not go all round
  SkyShares sky;                        ///< sky_shares()
};

/// The line as CSV with a line of names: azimuth, elevation (degrees), distance (along the line of sight, in
/// the cloud's unit), point_id, x, y, z of that point. Cells of azimuths without a horizon are empty.
std::string horizon_csv(std::span<const HorizonDirection> horizon);

/// The places that horizon_geojson() wants longitude and latitude of (lon_lat.h): the blocking points, in
/// order, azimuths without one left out, then the eye.
std::vector<glm::dvec3> horizon_places(std::span<const HorizonDirection> horizon, const HorizonFacts& facts);

/// The line as GeoJSON (RFC 7946): the observer, with the sky-view factors, and every blocking point with
/// azimuth, elevation, distance, point_id and z, as points; azimuths without a horizon have no geometry.
/// Without longitudes and latitudes the coordinates are the cloud's, and a member "coordinate_system" of the
/// collection says so.
std::string horizon_geojson(std::span<const HorizonDirection> horizon, const HorizonFacts& facts,
                            const std::optional<std::vector<glm::dvec3>>& on_globe);

}  // namespace alidade
