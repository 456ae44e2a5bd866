// SPDX-License-Identifier: MIT
#pragma once

#include "renderer/material.h"

namespace alidade {

/// How much air a beam from this elevation (degrees, seen through the air) crosses, as a multiple of the way
/// straight up: 1 at the zenith, 38 at the horizon. Elevations below 0 count as 0. Source: Kasten and Young,
/// Revised Optical Air Mass Tables and Approximation Formula, 1989.
double air_mass(double elevation);

/// Irradiance of the sun on a surface that faces it, under a clear sky: 4 in each channel above the air (so
/// that a sun at 40 degrees is about as bright as the scene's default), dimmed by exp(-depth air_mass
/// pressure / 1013.25). Depths at 610, 550 and 465 nm, for red, green and blue: Rayleigh's scattering as in
/// Hansen and Travis, Light Scattering in Planetary Atmospheres, 1974, and haze as in Angstrom's formula 0.05
/// (nm / 1000)^-1.3, which is rather clear air. Below the horizon none. Rounded to 1/10000, so that machines
/// whose mathematical functions differ in the last bit get the same pictures.
Rgb clear_sky_irradiance(double elevation, double pressure);

}  // namespace alidade
