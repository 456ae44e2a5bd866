// SPDX-License-Identifier: MIT
#include "geo/clear_sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace alidade {
namespace {

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

double air_mass(double elevation) {
  const double height = std::max(elevation, 0.0);
  return 1.0 / (std::sin(height * std::numbers::pi / 180.0) + 0.50572 * std::pow(height + 6.07995, -1.6364));
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

}  // namespace alidade
