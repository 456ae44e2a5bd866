// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// The air above a place, as far as it dims the sun.
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

}  // namespace alidade
