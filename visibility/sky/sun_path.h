// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/date_time.h"
#include "base/progress.h"
#include "cloud/crs.h"

namespace alidade::visibility {

struct SkylineCurve;

// The path of the sun over a position.

/// Parts of a time range; their borders are midnights of mean solar time, 4 minutes
/// earlier per degree to the east.
enum class SunPeriod { whole, year, month, day };

/// The sun in the middle of a step.
struct SunStep {
  double azimuth = 0.0;    ///< degrees clockwise from +y, [0, 360)
  double elevation = 0.0;  ///< degrees above the horizon, as seen through the air, > 0
  double hours = 0.0;      ///< length of the step
  int period = 0;          ///< its number in sun_periods()
  std::size_t number = 0;  ///< among all steps, with sun or without
};

/// A time range and a position on Earth.
struct SunSchedule {
  Moment from, to;                         ///< [from, to)
  double step_minutes = 10.0;              ///< [0.1, 1440]; the last step is cut short at `to`
  double latitude = 0.0, longitude = 0.0;  ///< degrees
  double grid_north = 0.0;                 ///< azimuth of +y, degrees clockwise from true north
  double height = 0.0;                     ///< metres above the sea, [-1000, 10000]; thin air refracts less
  SunPeriod period = SunPeriod::whole;     ///< parts that are summed separately
};

constexpr std::size_t k_most_sun_steps = 10'000'000;

/// The number of steps, with sun or without. Errors: numbers out of range, no time between from and to, more
/// than k_most_sun_steps steps.
std::size_t step_count(const SunSchedule& schedule);

/// The middle of a step and its length in hours. Requires number < step_count().
struct StepTime {
  Moment middle;
  double hours = 0.0;
};
StepTime step_time(const SunSchedule& schedule, std::size_t number);

/// The sun in the middle of every step in which it is up, in the order of time: geo::sun_position()
/// with the pressure at the height, angles rounded to 1e-6 degrees. `progress` is in steps. Cost: 0.04 ms
/// per step. Errors: as step_count(); height out of range.
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
