// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "extensions/radiation/weather.h"
#include "visibility/sky/sun_path.h"

namespace alidade::visibility {

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

/// What lights a site: a clear sky, or the weather.
struct LightSource {
  ClearAir air{};
  /// Linke turbidity of January to December, instead of that of `air`.
  std::optional<std::array<double, 12>> monthly_turbidity{};
  /// Irradiances with clouds, instead of those of a clear sky; null: none. Must outlive the object.
  const Weather* weather = nullptr;
};

/// A step of the sun's path with the irradiances by sun and sky.
struct LitStep {
  double azimuth = 0.0;           ///< as of SunStep
  double elevation = 0.0;         ///< as of SunStep
  double hours = 0.0;             ///< length of the step
  double irradiance = 0.0;        ///< of the sun's disc on a surface that faces it, W/m2
  double diffuse = 0.0;           ///< of the sky on the horizontal, W/m2
  double extraterrestrial = 0.0;  ///< extraterrestrial_irradiance(), W/m2
  int period = 0;                 ///< as of SunStep
};

/// The steps with their irradiances: those of the clear sky, or of the weather in the hour of the step's
/// middle. Steps of an hour in which the sun rises or sets get all of its energy, including that of the steps
/// without sun. Requires the sun_steps() of the schedule. Errors: turbidity or height out of range.
std::vector<LitStep> lit_steps(const SunSchedule& schedule, std::span<const SunStep> steps,
                               const LightSource& source);

}  // namespace alidade::visibility
