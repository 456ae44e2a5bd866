// SPDX-License-Identifier: MIT
#include "geo/sun.h"

#include <fmt/format.h>
#include <libnova/earth.h>
#include <libnova/nutation.h>
#include <libnova/sidereal_time.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "geo/earth.h"

namespace alidade::geo {
namespace {

constexpr double k_degree = std::numbers::pi / 180.0;
constexpr double k_arc_second = k_degree / 3600.0;
constexpr double k_astronomical_unit = 149597870700.0;  // metres
constexpr double k_epoch_2000 = 2451545.0, k_days_per_century = 36525.0;

/// Ecliptic coordinates of date, radians, and the distance in astronomical units.
struct Ecliptic {
  double longitude = 0.0, latitude = 0.0, distance = 0.0;
};

/// The Earth as seen from the sun. libnova gives it for the equinox of 2000; precession brings it to that of
/// date. Source: Meeus, chapter 21, equations 21.5 to 21.7.
Ecliptic earth_of_date(double julian_ephemeris_day) {
  ln_helio_posn earth{};
  ln_get_earth_helio_coords(julian_ephemeris_day, &earth);
  const double t = (julian_ephemeris_day - k_epoch_2000) / k_days_per_century;
  const double tilt = (47.0029 + (-0.03302 + 0.00006 * t) * t) * t * k_arc_second;
  const double node = 174.876384 * k_degree + (-869.8089 + 0.03536 * t) * t * k_arc_second;
  const double turn = (5029.0966 + (1.11113 - 0.000006 * t) * t) * t * k_arc_second;
  const double from_node = node - earth.L * k_degree, latitude = earth.B * k_degree;
  const double across = std::cos(latitude) * std::sin(from_node), above = std::sin(latitude);
  const double along = std::cos(latitude) * std::cos(from_node);
  return {turn + node - std::atan2(std::cos(tilt) * across - std::sin(tilt) * above, along),
          std::asin(std::cos(tilt) * above + std::sin(tilt) * across), earth.R};
}

/// From the Earth's centre to the observer, metres: x on the equator below the observer's meridian, y east, z
/// north.
glm::dvec3 position_of(const SunObserver& observer) {
  constexpr double k_equatorial_radius = 6378137.0, k_flattening = 1.0 / 298.257223563;
  constexpr double k_eccentricity_sq = k_flattening * (2.0 - k_flattening);
  const double sine = std::sin(observer.latitude * k_degree), cosine = std::cos(observer.latitude * k_degree);
  const double normal = k_equatorial_radius / std::sqrt(1.0 - k_eccentricity_sq * sine * sine);
  return {(normal + observer.height) * cosine, 0.0,
          (normal * (1.0 - k_eccentricity_sq) + observer.height) * sine};
}

/// Refraction at this elevation, degrees: how much higher a body appears than it is. Source: NREL's
/// algorithm, equation 42, after Saemundsson 1986.
double refraction(double elevation, const SunObserver& observer) {
  // Half the sun's disc and the refraction at the horizon.
  constexpr double k_upper_limb_sets = -(0.26667 + 0.5667);
  if (elevation < k_upper_limb_sets) return 0.0;
  const double density = observer.pressure / 1010.0 * 283.0 / (273.0 + observer.temperature);
  return density * 1.02 / (60.0 * std::tan((elevation + 10.3 / (elevation + 5.11)) * k_degree));
}

/// For years before `end`: the sum of coefficients times ((year - origin) / scale)^n.
struct YearPolynomial {
  double end = 0.0, origin = 0.0, scale = 1.0;
  std::vector<double> coefficients{};
};

double value_of(const YearPolynomial& polynomial, double year) {
  const double t = (year - polynomial.origin) / polynomial.scale;
  double value = 0.0;
  for (auto each = polynomial.coefficients.rbegin(); each != polynomial.coefficients.rend(); ++each)
    value = value * t + *each;
  return value;
}

constexpr double k_above_the_air = 4.0;
constexpr double k_micrometres[3] = {0.610, 0.550, 0.465};

/// Of the whole air straight up. Source: Hansen and Travis 1974, equation 2.30.
double rayleigh_depth(double micrometres) {
  const double square = micrometres * micrometres;
  return 0.008569 / (square * square) * (1.0 + 0.0113 / square + 0.00013 / (square * square));
}

double haze_depth(double micrometres) {
  return 0.05 * std::pow(micrometres, -1.3);
}

}  // namespace

SunPosition sun_position(const Moment& moment, const SunObserver& observer,
                         std::optional<double> terrestrial_minus_universal) {
  const double universal = julian_day(moment);
  const double ephemeris =
      universal + terrestrial_minus_universal.value_or(delta_t(decimal_year(moment))) / 86400.0;

  const Ecliptic earth = earth_of_date(ephemeris);
  ln_nutation nutation{};
  ln_get_nutation(ephemeris, &nutation);
  const double obliquity = (nutation.ecliptic + nutation.obliquity) * k_degree;
  const double aberration = 20.4898 * k_arc_second / earth.distance;
  const double longitude = earth.longitude + std::numbers::pi + nutation.longitude * k_degree - aberration;
  const double latitude = -earth.latitude;

  const glm::dvec3 on_ecliptic(std::cos(latitude) * std::cos(longitude),
                               std::cos(latitude) * std::sin(longitude), std::sin(latitude));
  const double along = on_ecliptic.y * std::cos(obliquity) - on_ecliptic.z * std::sin(obliquity);
  const double north = on_ecliptic.y * std::sin(obliquity) + on_ecliptic.z * std::cos(obliquity);
  const double right_ascension = std::atan2(along, on_ecliptic.x);
  const double on_equator = std::hypot(on_ecliptic.x, along);

  const double sidereal = 15.0 * ln_get_mean_sidereal_time(universal) +
                          nutation.longitude * std::cos(obliquity) + observer.longitude;
  const double hour_angle = sidereal * k_degree - right_ascension;
  // Seen from the Earth's centre, and from there to the observer: this is the parallax.
  const glm::dvec3 direction(on_equator * std::cos(hour_angle), -on_equator * std::sin(hour_angle), north);
  const glm::dvec3 seen = earth.distance * k_astronomical_unit * direction - position_of(observer);

  const double sine = std::sin(observer.latitude * k_degree), cosine = std::cos(observer.latitude * k_degree);
  const double to_north = cosine * seen.z - sine * seen.x, upward = cosine * seen.x + sine * seen.z;
  SunPosition position;
  position.azimuth = wrapped_degrees(std::atan2(seen.y, to_north) / k_degree);
  position.geometric_elevation = std::atan2(upward, std::hypot(seen.y, to_north)) / k_degree;
  position.elevation = position.geometric_elevation + refraction(position.geometric_elevation, observer);
  return position;
}

double delta_t(double year) {
  const std::array<YearPolynomial, 13> pieces{{
      {1600, 1000, 100, {1574.2, -556.01, 71.23472, 0.319781, -0.8503463, -0.005050998, 0.0083572073}},
      {1700, 1600, 1, {120, -0.9808, -0.01532, 1.0 / 7129}},
      {1800, 1700, 1, {8.83, 0.1603, -0.0059285, 0.00013336, -1.0 / 1174000}},
      {1860,
       1800,
       1,
       {13.72, -0.332447, 0.0068612, 0.0041116, -0.00037436, 0.0000121272, -0.0000001699, 0.000000000875}},
      {1900, 1860, 1, {7.62, 0.5737, -0.251754, 0.01680668, -0.0004473624, 1.0 / 233174}},
      {1920, 1900, 1, {-2.79, 1.494119, -0.0598939, 0.0061966, -0.000197}},
      {1941, 1920, 1, {21.20, 0.84493, -0.076100, 0.0020936}},
      {1961, 1950, 1, {29.07, 0.407, -1.0 / 233, 1.0 / 2547}},
      {1986, 1975, 1, {45.45, 1.067, -1.0 / 260, -1.0 / 718}},
      {2005, 2000, 1, {63.86, 0.3345, -0.060374, 0.0017275, 0.000651814, 0.00002373599}},
      {2050, 2000, 1, {62.92, 0.32217, 0.005589}},
      // With u in centuries from 1820: -20 + 32 u^2 - 0.5628 (2150 - year), which leads over to the last.
      {2150, 1820, 100, {-20 - 0.5628 * 330, 0.5628 * 100, 32}},
      {INFINITY, 1820, 100, {-20, 0, 32}},
  }};
  for (const YearPolynomial& piece : pieces)
    if (year < piece.end) return value_of(piece, year);
  return value_of(pieces.back(), year);
}

Rgb clear_sky_irradiance(double elevation, double pressure) {
  Rgb irradiance(0.0f);
  if (elevation < 0.0) return irradiance;
  const double air = air_mass(elevation) * pressure / 1013.25;
  for (int channel = 0; channel < 3; ++channel) {
    const double depth = rayleigh_depth(k_micrometres[channel]) + haze_depth(k_micrometres[channel]);
    irradiance[channel] =
        static_cast<float>(std::round(k_above_the_air * std::exp(-depth * air) * 1e4) / 1e4);
  }
  return irradiance;
}

PlacedSun place_sun(const SunByTime& by_time, const std::optional<SceneMap>& map) {
  std::optional<GroundPosition> ground;
  if (map && !map->crs.empty()) ground = ground_position(map->crs, map->center);
  if (!ground && !(by_time.latitude && by_time.longitude)) {
    throw Error({.problem = "the sun position requires latitude and longitude",
                 .expected =
                     "\"latitude\" and \"longitude\" in the scene's sun, --sun-place LAT,LON, or a cloud "
                     "with a reference system",
                 .found = !map               ? "no cloud"
                          : map->crs.empty() ? "a cloud without a reference system"
                                             : "a reference system without a location on Earth"});
  }
  PlacedSun placed;
  placed.latitude = by_time.latitude ? *by_time.latitude : ground->latitude;
  placed.longitude = by_time.longitude ? *by_time.longitude : ground->longitude;
  placed.is_map_known = ground.has_value();
  placed.grid_north = ground ? rounded_degrees(ground->grid_north) : 0.0;
  const SunPosition position = sun_position(by_time.moment, {.latitude = placed.latitude,
                                                             .longitude = placed.longitude,
                                                             .height = by_time.height,
                                                             .pressure = by_time.pressure,
                                                             .temperature = by_time.temperature});
  placed.true_azimuth = wrapped_degrees(rounded_degrees(position.azimuth));
  placed.is_up = position.elevation > 0.0;
  placed.sun.azimuth = wrapped_degrees(rounded_degrees(placed.true_azimuth - placed.grid_north));
  placed.sun.elevation = rounded_degrees(position.elevation);
  placed.sun.angular_diameter = by_time.angular_diameter;
  placed.sun.irradiance =
      by_time.irradiance ? *by_time.irradiance : clear_sky_irradiance(placed.sun.elevation, by_time.pressure);
  return placed;
}

std::string describe(const SunByTime& by_time, const PlacedSun& placed) {
  const std::string north =
      !placed.is_map_known ? " (+y assumed to be true north)"
      : placed.grid_north == 0.0
          ? ""
          : fmt::format(" ({:.6f} from +y: grid north is {:.6f} off)", placed.sun.azimuth, placed.grid_north);
  return fmt::format(
      "sun at azimuth {:.6f}{}, elevation {:.6f} degrees, {} at latitude {:.6f}, longitude {:.6f}",
      placed.true_azimuth, north, placed.sun.elevation, date_time_text(by_time.moment), placed.latitude,
      placed.longitude);
}

}  // namespace alidade::geo
