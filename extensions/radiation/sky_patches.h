// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "visibility/sky/sky_view.h"

// The sky as 145 patches of even radiance, as Tregenza divided it for measurements and Robinson and Stone
// used it for radiation: rows of 12 degrees with 30, 30, 24, 24, 18, 12 and 6 patches, the middle of the
// first patch of a row in the north, and a cap of 6 degrees around the zenith. Sources: Tregenza, Subdivision
// of the Sky Hemisphere for Luminance Measurements, 1987, table 1; Robinson and Stone, Irradiation Modelling
// Made Simple: the Cumulative Sky Approach and its Applications, 2004.

namespace alidade::visibility {

constexpr int k_sky_patches = 145;

/// Requires 0 <= patch < k_sky_patches; the last one is the cap.
SkyCell sky_patch(int patch);

/// The patch that a direction is in. Requires an elevation from 0 to 90 degrees.
int sky_patch_at(double azimuth, double elevation);

/// The sun, and the irradiances that make a sky clear or overcast.
struct SkyState {
  double azimuth = 0.0, elevation = 0.0;  ///< of the sun, degrees; elevation above 0
  double direct_normal = 0.0;             ///< of a surface that faces the sun, by its disc, W/m2
  double diffuse_horizontal = 0.0;        ///< of the horizontal, by the sky without the disc, W/m2
  double extraterrestrial = 1367.0;       ///< extraterrestrial_irradiance(), W/m2
};

/// Radiance of every patch, W/m2/sr: that of the all-weather sky in the middle of the patch, scaled so
/// that all patches give the horizontal its diffuse irradiance. Clearness and brightness: Perez, Ineichen,
/// Seals, Michalsky, Stewart, Modeling Daylight Availability and Irradiance Components From Direct and
/// Global Irradiance, 1990, equations 1 and 2; distribution: Perez, Seals, Michalsky, All-Weather Model
/// for Sky Luminance Distribution, 1993, equations 1 and 6 to 8 and table 1. As in Radiance's gendaymtx,
/// the sun is at least 3 degrees from the zenith, and the brightness of skies of middle clearness is at
/// least 0.2. Rounded to 1e-6.
std::array<double, k_sky_patches> sky_radiances(const SkyState& state);

}  // namespace alidade::visibility
