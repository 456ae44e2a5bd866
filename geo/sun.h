// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec2.hpp>
#include <numbers>
#include <optional>
#include <string>

#include "base/color.h"
#include "base/date_time.h"
#include "cloud/crs.h"

namespace alidade::geo {

/// An angle in [0, 360).
inline double wrapped_degrees(double degrees) {
  const double rest = std::fmod(degrees, 360.0);
  return rest < 0.0 ? rest + 360.0 : rest;
}

/// To a millionth of a degree, so that the last bits of libraries do not matter; -0 becomes 0.
inline double rounded_degrees(double degrees) {
  return std::round(degrees * 1e6) / 1e6 + 0.0;
}

/// The sun: a disc of even radiance, infinitely far away.
struct Sun {
  double azimuth = 135.0;            ///< degrees, clockwise from north (+y), so 90 is east (+x)
  double elevation = 40.0;           ///< degrees above the horizon, (-90, 90]
  Rgb irradiance{3.0f, 2.9f, 2.7f};  ///< on a surface that faces it
  double angular_diameter = 0.53;    ///< degrees, [0, 180); 0 = parallel light
};

/// A sun by date, time and location. place_sun() makes a Sun of it once the cloud is read.
struct SunByTime {
  Moment moment;
  std::optional<double> latitude{}, longitude{};  ///< degrees; both or none: those of the cloud
  double height = 0.0;                            ///< metres above the sea, [-1000, 100000]
  double pressure = 1013.25;                      ///< of the air there, hPa = mbar, [0, 2000]
  double temperature = 10.0;                      ///< of the air there, degrees Celsius, [-150, 100]
  std::optional<Rgb> irradiance{};                ///< empty = that of a clear sky, by elevation
  double angular_diameter = 0.53;                 ///< as Sun's
};

/// The observer's location on Earth, and the air there.
struct SunObserver {
  double latitude = 0.0;      ///< degrees north, [-90, 90]
  double longitude = 0.0;     ///< degrees east
  double height = 0.0;        ///< metres above the ellipsoid; heights above the sea do as well
  double pressure = 1013.25;  ///< of the air there (not brought down to sea level), hPa = mbar; 0 = no air
  double temperature = 10.0;  ///< of the air, degrees Celsius, above -273
};

/// The direction of the middle of the sun's disc, as seen by the observer and not from the Earth's centre.
struct SunPosition {
  double azimuth = 0.0;              ///< degrees clockwise from true north, [0, 360)
  double elevation = 0.0;            ///< degrees above the horizon, as seen through the air
  double geometric_elevation = 0.0;  ///< elevation without refraction
};

/// Within 0.0001 degrees of the published example of NREL's algorithm (Reda and Andreas, Solar Position
/// Algorithm for Solar Radiation Applications, 2003). Good to 0.005 degrees in our times: 0.004 are the
/// difference (below 0.9 s since 1972) between UTC and the rotation of the Earth. Far from our times the
/// rotation itself is an estimate, see delta_t(). The Earth's orbit is VSOP87 as libnova has it; precession,
/// nutation, aberration, sidereal time as in Meeus, Astronomical Algorithms, 1998, chapters 12, 21, 22, 25;
/// parallax from the observer's location on the WGS 84 ellipsoid; refraction as in NREL's algorithm, none
/// where the upper limb is below the horizon. `terrestrial_minus_universal`: seconds; delta_t() of the year
/// if empty. Not thread safe: libnova caches its last results.
SunPosition sun_position(const Moment& moment, const SunObserver& observer,
                         std::optional<double> terrestrial_minus_universal = {});

/// Terrestrial minus universal time, seconds, for a year like 2003.8. Source: Espenak and Meeus, Five
/// Millennium Canon of Solar Eclipses, NASA/TP-2006-214141; measured up to 2005, a forecast after it.
double delta_t(double year);

/// How much air a beam from this elevation (degrees, seen through the air) crosses, as a multiple of the way
/// straight up: 1 at the zenith, 38 at the horizon. Elevations below 0 count as 0. Source: Kasten and Young,
/// Revised Optical Air Mass Tables and Approximation Formula, 1989.
inline double air_mass(double elevation) {
  const double height = std::max(elevation, 0.0);
  return 1.0 / (std::sin(height * std::numbers::pi / 180.0) + 0.50572 * std::pow(height + 6.07995, -1.6364));
}

/// Irradiance of the sun on a surface that faces it, under a clear sky: 4 in each channel above the air (so
/// that a sun at 40 degrees is about as bright as the scene's default), dimmed by exp(-depth air_mass
/// pressure / 1013.25). Depths at 610, 550 and 465 nm, for red, green and blue: Rayleigh's scattering as in
/// Hansen and Travis, Light Scattering in Planetary Atmospheres, 1974, and haze as in Angstrom's formula 0.05
/// (nm / 1000)^-1.3, which is rather clear air. Below the horizon none. Rounded to 1/10000, so that machines
/// whose mathematical functions differ in the last bit get equal images.
Rgb clear_sky_irradiance(double elevation, double pressure);

/// The map of a scene.
struct SceneMap {
  Crs crs;            ///< the cloud's; empty = none
  glm::dvec2 center;  ///< where in it the scene is: the middle of the cloud
};

/// A sun whose position in the sky has been computed.
struct PlacedSun {
  Sun sun;  ///< azimuth counts from +y, as everywhere in scenes; azimuth and elevation rounded to 1e-6
            ///< degrees
  bool is_up = false;         ///< whether its middle is above the horizon; else it lights nothing
  double true_azimuth = 0.0;  ///< degrees clockwise from true north
  double grid_north = 0.0;    ///< azimuth of +y, degrees clockwise from true north; 0 without a map
  bool is_map_known = false;  ///< whether grid_north comes from a map
  double latitude = 0.0, longitude = 0.0;
};

/// The sun in the sky. Latitude and longitude are by default those of the scene on its map; with a map
/// azimuths are turned from true north to +y, without one +y is taken for true north. An automatic irradiance
/// is clear_sky_irradiance(). Rounding lets machines whose mathematical functions differ in the last bit
/// agree. Errors: neither latitude and longitude nor a map that gives them.
PlacedSun place_sun(const SunByTime& by_time, const std::optional<SceneMap>& map);

/// One line for people and for the metadata of images.
std::string describe(const SunByTime& by_time, const PlacedSun& placed);

}  // namespace alidade::geo
