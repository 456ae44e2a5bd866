// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <vector>

#include "base/date_time.h"
#include "base/progress.h"
#include "cloud/crs.h"
#include "visibility/sky/sun_hours.h"

namespace alidade::visibility {

/// The air above a position, as far as it dims the sun.
struct ClearAir {
  /// How many clean dry atmospheres would dim the sun as much, at an air mass of 2: 2 very clear and cold,
  /// 3 clear and warm, 5 humid, 7 polluted. [1, 20]
  double linke_turbidity = 3.0;
  double height = 0.0;  ///< metres above the sea, [-1000, 10000]
};

/// Irradiance by the sun's disc alone, of a surface that faces it, W/m2, under a clear sky: 1367 W/m2 above
/// the air, at the Earth's mean distance, corrected for that of `day_of_year` (1 = 1 January; fractions
/// count), times exp(-0.8662 T m d), with T the turbidity, m the air mass (air_mass(), times exp(-height /
/// 8434.5)) and d the optical thickness of clean dry air. `elevation`: degrees, as seen through the air; 0 or
/// less gives 0. Rounded to 0.0001, so that machines whose mathematical functions differ in the last bit
/// agree. The light of the sky around the sun is not in it.
/// Sources: European Solar Radiation Atlas: Rigollier, Bauer, Wald, On the Clear Sky Model of the ESRA, 2000;
/// d: Kasten, The Linke Turbidity Factor Based on Improved Values of the Integral Rayleigh Optical Thickness,
/// 1996. r.sun of GRASS computes the same.
double beam_irradiance(double elevation, double day_of_year, const ClearAir& air);

/// A time range and a position on Earth.
struct SunSchedule {
  Moment from, to;                         ///< [from, to)
  double step_minutes = 10.0;              ///< [0.1, 1440]; the last step is cut short at `to`
  double latitude = 0.0, longitude = 0.0;  ///< degrees
  double grid_north = 0.0;                 ///< azimuth of +y, degrees clockwise from true north
  ClearAir air;
};

constexpr std::size_t k_most_sun_steps = 10'000'000;

/// Where the sun is in the middle of every step in which it is up, in the order of time: sun_position()
/// with the pressure that belongs to the height, angles rounded to 1e-6 degrees. `progress` is in steps.
/// Cost: 0.04 ms per step. Errors: numbers out of range, no time between from and to, over k_most_sun_steps
/// steps.
std::vector<SunStep> sun_steps(const SunSchedule& schedule, const Progress& progress = {});

/// Sets latitude, longitude and grid_north of the position (x, y) of a map (geo/earth.h); a latitude
/// and longitude that are given stay. Without a map +y is taken for true north. Returns whether the map defined
/// grid north. Errors: neither a position nor a map that defines it.
bool place_schedule(const Crs& crs, const glm::dvec2& center,
                    const std::optional<glm::dvec2>& latitude_longitude, SunSchedule& schedule);

}  // namespace alidade::visibility
