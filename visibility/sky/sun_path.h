// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <vector>

#include "base/date_time.h"
#include "base/progress.h"
#include "cloud/crs.h"
#include "visibility/sky/beam_irradiance.h"
#include "visibility/sky/sun_bins.h"

namespace alidade {

/// A time range and a place on Earth.
struct SunSchedule {
  Moment from, to;                         ///< [from, to)
  double step_minutes = 10.0;              ///< [0.1, 1440]; the last step is cut short at `to`
  double latitude = 0.0, longitude = 0.0;  ///< degrees
  double grid_north = 0.0;                 ///< azimuth of +y, degrees clockwise from true north
  ClearAir air;
};

constexpr std::size_t k_most_sun_steps = 10'000'000;

/// Where the sun stands in the middle of every step in which it is up, in the order of time: sun_position()
/// with the pressure that belongs to the height, angles rounded to 1e-6 degrees. `progress` is in steps.
/// Cost: 0.04 ms per step. Errors: numbers out of range, no time between from and to, over k_most_sun_steps
/// steps.
std::vector<SunStep> sun_steps(const SunSchedule& schedule, const Progress& progress = {});

/// Sets latitude, longitude and grid_north of the place (x, y) of a map (geo/earth.h); a latitude
/// and longitude that are given stay. Without a map +y is taken for true north. Answers whether the map told
/// grid north. Errors: neither a place nor a map that tells it.
bool place_schedule(const Crs& crs, const glm::dvec2& center,
                    const std::optional<glm::dvec2>& latitude_longitude, SunSchedule& schedule);

}  // namespace alidade
