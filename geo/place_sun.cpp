// SPDX-License-Identifier: MIT
#include "geo/place_sun.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "geo/clear_sky.h"
#include "geo/ground_place.h"
#include "geo/sun.h"

namespace alidade {
namespace {

double rounded(double degrees) {
  return std::round(degrees * 1e6) / 1e6 + 0.0;
}

/// In [0, 360).
double wrapped(double degrees) {
  const double rest = std::fmod(degrees, 360.0);
  return rest < 0.0 ? rest + 360.0 : rest;
}

}  // namespace

PlacedSun place_sun(const SunByTime& by_time, const std::optional<SceneMap>& map) {
  std::optional<GroundPlace> ground;
  if (map && !map->crs.empty()) ground = ground_place(map->crs, map->center);
  if (!ground && !(by_time.latitude && by_time.longitude)) {
    throw Error({.problem = "the place of the sun needs a latitude and a longitude",
                 .expected =
                     "\"latitude\" and \"longitude\" in the scene's sun, --sun-place LAT,LON, or a cloud "
                     "with a reference system",
                 .found = !map               ? "no cloud"
                          : map->crs.empty() ? "a cloud without a reference system"
                                             : "a reference system that tells no place on Earth"});
  }
  PlacedSun placed;
  placed.latitude = by_time.latitude ? *by_time.latitude : ground->latitude;
  placed.longitude = by_time.longitude ? *by_time.longitude : ground->longitude;
  placed.is_map_known = ground.has_value();
  placed.grid_north = ground ? rounded(ground->grid_north) : 0.0;
  const SunPosition position = sun_position(by_time.moment, {.latitude = placed.latitude,
                                                             .longitude = placed.longitude,
                                                             .height = by_time.height,
                                                             .pressure = by_time.pressure,
                                                             .temperature = by_time.temperature});
  placed.true_azimuth = wrapped(rounded(position.azimuth));
  placed.is_up = position.elevation > 0.0;
  placed.sun.azimuth = wrapped(rounded(placed.true_azimuth - placed.grid_north));
  placed.sun.elevation = rounded(position.elevation);
  placed.sun.angular_diameter = by_time.angular_diameter;
  placed.sun.irradiance =
      by_time.irradiance ? *by_time.irradiance : clear_sky_irradiance(placed.sun.elevation, by_time.pressure);
  return placed;
}

std::string describe(const SunByTime& by_time, const PlacedSun& placed) {
  const std::string north =
      !placed.is_map_known ? " (+y taken for true north)"
      : placed.grid_north == 0.0
          ? ""
          : fmt::format(" ({:.6f} from +y: grid north is {:.6f} off)", placed.sun.azimuth, placed.grid_north);
  return fmt::format(
      "sun at azimuth {:.6f}{}, elevation {:.6f} degrees, {} at latitude {:.6f}, longitude {:.6f}",
      placed.true_azimuth, north, placed.sun.elevation, date_time_text(by_time.moment), placed.latitude,
      placed.longitude);
}

}  // namespace alidade
