// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <string>

#include "cloud/crs.h"
#include "renderer/scene.h"

namespace alidade {

/// The map a scene stands on.
struct SceneMap {
  Crs crs;            ///< the cloud's; empty = none
  glm::dvec2 center;  ///< where in it the scene is: the middle of the cloud
};

/// A sun whose place in the sky has been computed.
struct PlacedSun {
  Sun sun;  ///< azimuth counts from +y, as everywhere in scenes; azimuth and elevation rounded to 1e-6
            ///< degrees
  bool is_up = false;         ///< whether its middle is above the horizon; else it lights nothing
  double true_azimuth = 0.0;  ///< degrees clockwise from true north
  double grid_north = 0.0;    ///< azimuth of +y, degrees clockwise from true north; 0 where no map tells it
  bool is_map_known = false;  ///< whether grid_north comes from a map
  double latitude = 0.0, longitude = 0.0;
};

/// Where the sun stands. Without latitude and longitude they are those of the scene on its map; with a map
/// azimuths are turned from true north to +y, without one +y is taken for true north. An automatic irradiance
/// is clear_sky_irradiance(). Rounding lets machines whose mathematical functions differ in the last bit
/// agree. Errors: neither latitude and longitude nor a map that tells them.
PlacedSun place_sun(const SunByTime& by_time, const std::optional<SceneMap>& map);

/// One line for people and for the metadata of pictures.
std::string describe(const SunByTime& by_time, const PlacedSun& placed);

}  // namespace alidade
