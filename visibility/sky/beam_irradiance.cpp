// SPDX-License-Identifier: MIT
#include "visibility/sky/beam_irradiance.h"

#include <cmath>
#include <numbers>

#include "geo/sun.h"

namespace alidade {
namespace {

/// Of clean dry air, per air mass. Source: Kasten 1996, as in Rigollier et al. 2000, equations 11 and 12.
double rayleigh_thickness(double mass) {
  constexpr double k_low_sun = 20.0;
  if (mass > k_low_sun) return 1.0 / (10.4 + 0.718 * mass);
  return 1.0 / (6.6296 + mass * (1.7513 + mass * (-0.1202 + mass * (0.0065 - 0.00013 * mass))));
}

}  // namespace

double beam_irradiance(double elevation, double day_of_year, const ClearAir& air) {
  if (!(elevation > 0.0)) return 0.0;
  constexpr double k_solar_constant = 1367.0, k_days = 365.25;
  constexpr double k_eccentricity = 0.03344, k_perihelion = 0.048869;
  const double turn = 2.0 * std::numbers::pi * day_of_year / k_days;
  const double above = k_solar_constant * (1.0 + k_eccentricity * std::cos(turn - k_perihelion));
  const double mass = air_mass(elevation) * std::exp(-air.height / 8434.5);
  const double dimmed = above * std::exp(-0.8662 * air.linke_turbidity * mass * rayleigh_thickness(mass));
  return std::round(dimmed * 1e4) / 1e4;
}

}  // namespace alidade
