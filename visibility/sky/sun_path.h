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
#include "visibility/sky/irradiance.h"
#include "visibility/sky/weather.h"

namespace alidade::visibility {

struct SkylineCurve;

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
/// sky (irradiance.h), or of the weather in the hour of the step's middle. Steps of an hour in which
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
