// SPDX-License-Identifier: MIT
#include "visibility/sky/irradiance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/exact_math.h"
#include "geo/sun.h"

namespace alidade::visibility {
namespace {

/// Optical thickness of clean dry air, per air mass. Source: Kasten 1996, as in Rigollier et al.
/// 2000, equations 11 and 12.
double rayleigh_thickness(double mass) {
  constexpr double k_low_sun = 20.0;
  if (mass > k_low_sun) return 1.0 / (10.4 + 0.718 * mass);
  return 1.0 / (6.6296 + mass * (1.7513 + mass * (-0.1202 + mass * (0.0065 - 0.00013 * mass))));
}

double rounded_irradiance(double irradiance) {
  return std::round(irradiance * 1e4) / 1e4;
}

}  // namespace

double extraterrestrial_irradiance(double day_of_year) {
  constexpr double k_solar_constant = 1367.0, k_days = 365.25;
  constexpr double k_eccentricity = 0.03344, k_perihelion = 0.048869;
  const double turn = 2.0 * std::numbers::pi * day_of_year / k_days;
  return k_solar_constant * (1.0 + k_eccentricity * std::cos(turn - k_perihelion));
}

double beam_irradiance(double elevation, double day_of_year, const ClearAir& air) {
  if (!(elevation > 0.0)) return 0.0;
  const double mass = geo::air_mass(elevation) * std::exp(-air.height / 8434.5);
  return rounded_irradiance(extraterrestrial_irradiance(day_of_year) *
                            std::exp(-0.8662 * air.linke_turbidity * mass * rayleigh_thickness(mass)));
}

double diffuse_irradiance(double elevation, double day_of_year, const ClearAir& air) {
  if (!(elevation > 0.0)) return 0.0;
  constexpr double k_least = 0.0022;  // of the sky's transmission where the sun is at the horizon
  const double t = air.linke_turbidity, sine = sine_cosine_of_degrees(elevation).sine;
  const double transmission = -0.015843 + t * (0.030543 + t * 0.0003797);
  const double constant = std::max(0.26463 + t * (-0.061581 + t * 0.0031408), k_least / transmission),
               linear = 2.04020 + t * (0.018945 - t * 0.011161),
               square = -1.3025 + t * (0.039231 + t * 0.0085079);
  return rounded_irradiance(extraterrestrial_irradiance(day_of_year) * transmission *
                            (constant + sine * (linear + sine * square)));
}

}  // namespace alidade::visibility
