// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/date_time.h"
#include "base/progress.h"
#include "cloud/crs.h"
#include "visibility/sky/weather.h"

namespace alidade::visibility {

struct SkylineCurve;

// Light of the sun and of a clear sky on open ground, as in the European Solar Radiation Atlas and in r.sun
// of GRASS.

/// The properties of the air above a position that dim the sun.
struct ClearAir {
  /// Number of clean dry atmospheres that would dim the sun as much, at an air mass of 2: 2 very clear and
  /// cold, 3 clear and warm, 5 humid, 7 polluted. [1, 20]
  double linke_turbidity = 3.0;
  double height = 0.0;  ///< metres above the sea, [-1000, 10000]
};

/// Irradiance of a surface that faces the sun above the air, W/m2: 1367 at the Earth's mean distance,
/// corrected for that of `day_of_year` (1 = 1 January; fractions count). Source: Hofierka and Suri, The solar
/// radiation model for Open source GIS, 2002, equations 1 and 2.
double extraterrestrial_irradiance(double day_of_year);

/// Irradiance by the sun's disc alone, of a surface that faces it, W/m2, under a clear sky:
/// extraterrestrial_irradiance() times exp(-0.8662 T m d), with T the turbidity, m the air mass
/// (geo::air_mass(), times exp(-height / 8434.5)) and d the optical thickness of clean dry air. `elevation`:
/// degrees, as seen through the air; 0 or less gives 0. Rounded to 0.0001, so that machines agree whose
/// mathematical functions differ in the last bit. Sources: Rigollier, Bauer, Wald, On the Clear Sky Model of
/// the ESRA, 2000, the beam component; d: Kasten, The Linke Turbidity Factor Based on Improved Values of the
/// Integral Rayleigh Optical Thickness, 1996.
double beam_irradiance(double elevation, double day_of_year, const ClearAir& air);

/// Irradiance of the horizontal by a clear sky without the sun's disc, W/m2: extraterrestrial_irradiance()
/// times the transmission at the zenith Tn(T) times the function Fd of the elevation, a square polynomial of
/// its sine; 0 or less gives 0. Rounded as beam_irradiance(). Sources: Rigollier, Bauer, Wald 2000, the
/// diffuse component; Hofierka and Suri 2002, equations 22 to 25, as in r.sun: the height is not used.
double diffuse_irradiance(double elevation, double day_of_year, const ClearAir& air);

// The path of the sun over a position, and the irradiances along it.

/// Parts of a time range; their borders are midnights of mean solar time, 4 minutes
/// earlier per degree to the east.
enum class SunPeriod { whole, year, month, day };

/// The sun in the middle of a step, and the irradiances by sun and sky.
struct SunStep {
  double azimuth = 0.0;           ///< degrees clockwise from +y, [0, 360)
  double elevation = 0.0;         ///< degrees above the horizon, as seen through the air, > 0
  double hours = 0.0;             ///< length of the step
  double irradiance = 0.0;        ///< of the sun's disc on a surface that faces it, W/m2
  double diffuse = 0.0;           ///< of the sky on the horizontal, W/m2
  double extraterrestrial = 0.0;  ///< extraterrestrial_irradiance(), W/m2
  int period = 0;                 ///< its number in sun_periods()
};

/// A time range and a position on Earth.
struct SunSchedule {
  Moment from, to;                         ///< [from, to)
  double step_minutes = 10.0;              ///< [0.1, 1440]; the last step is cut short at `to`
  double latitude = 0.0, longitude = 0.0;  ///< degrees
  double grid_north = 0.0;                 ///< azimuth of +y, degrees clockwise from true north
  ClearAir air;
  /// Linke turbidity of January to December, instead of that of `air`.
  std::optional<std::array<double, 12>> monthly_turbidity{};
  /// Irradiances with clouds, instead of those of a clear sky; null: none. Must outlive the schedule.
  const Weather* weather = nullptr;
  SunPeriod period = SunPeriod::whole;  ///< parts that are summed separately
};

constexpr std::size_t k_most_sun_steps = 10'000'000;

/// The sun in the middle of every step in which it is up, in the order of time: geo::sun_position()
/// with the pressure at the height, angles rounded to 1e-6 degrees. Irradiances are those of the clear
/// sky, or of the weather in the hour of the step's middle. Steps of an hour in which
/// the sun rises or sets get all of its energy, including that of the steps without sun. `progress` is
/// in steps. Cost: 0.04 ms per step. Errors: numbers out of range, no time between from and to, more
/// than k_most_sun_steps steps.
std::vector<SunStep> sun_steps(const SunSchedule& schedule, const Progress& progress = {});

/// Names of the periods from the first to the last that the range overlaps, in order: "2026", "2026-06",
/// "2026-06-21"; one empty name for the whole. Requires from < to. Errors: more than k_most_sun_periods.
constexpr int k_most_sun_periods = 366;
std::vector<std::string> sun_periods(const SunSchedule& schedule);

/// Sets latitude, longitude and grid_north of the position (x, y) of a map (geo/earth.h); a latitude and
/// longitude that are given are kept. Without a map +y counts as true north. Returns whether the map defined
/// grid north. Errors: latitude and longitude are neither given nor defined by a map.
bool place_schedule(const Crs& crs, const glm::dvec2& center,
                    const std::optional<glm::dvec2>& latitude_longitude, SunSchedule& schedule);

/// The path of the sun on the longest, the shortest and an even day of the year in which a schedule begins
/// (21 June, 20 March, 21 December), with their dates as labels, and behind them a line for every whole hour
/// of mean solar time, from the shortest to the longest day, named where it meets the first path. Only above
/// the horizontal. Cost: 0.05 seconds. Errors: as sun_steps().
std::vector<SkylineCurve> sun_curves(const SunSchedule& schedule);

}  // namespace alidade::visibility
