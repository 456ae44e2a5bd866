// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "extensions/radiation/irradiance.h"
#include "visibility/sky/sun_light.h"

// Direct and diffuse light of a time range, summed by direction once for all receivers.

namespace alidade::visibility {

/// Light summed over time, energies as vectors towards the light: the dot product of an energy and the unit
/// normal of a receiver is the energy that the receiver gets, Wh/m2. Exact if the receiver faces all of the
/// light.
struct LightSums {
  double hours = 0.0;                  ///< of direct sun
  glm::dvec3 beam{0.0}, diffuse{0.0};  ///< energies of the sun's disc and of the sky, Wh/m2

  LightSums& operator+=(const LightSums& other) {
    hours += other.hours;
    beam += other.beam;
    diffuse += other.diffuse;
    return *this;
  }
};

using LightBin = BinOf<LightSums>;
using LightFan = FanOf<LightSums>;
/// The z of an energy of `open` is what open level ground gets.
using EnergyLight = LightOf<LightSums>;

struct EnergyLightOptions {
  double bin = 0.0;          ///< as of LightOptions
  bool has_sky = true;       ///< whether to add the diffuse light of the sky to that of the sun's disc
  bool by_horizons = false;  ///< as of LightOptions
};

/// Direction of the line of sight that represents a patch of the sky (sky_patches.h). The elevations differ
/// along a row of patches, so that a level edge hides the same share of the lines as of the row. Requires
/// 0 <= patch < k_sky_patches.
glm::dvec3 line_into_patch(int patch);

/// Groups the light of the sun's steps, and of the sky during them, by direction: that of the sun as
/// sun_light().
///
/// The sky is the cumulative sky of sky_patches.h: the radiances of each patch are summed over the steps. The
/// light of each of the 145 patches is a bin in the direction of line_into_patch(). For fans, the sky
/// consists of cells: 1 degree of elevation by `options.bin` degrees of azimuth, at most 2 (2 if it is 0).
/// Patches, lines and cells preserve the integral of direction over solid angle: open level ground gets
/// exactly the diffuse energy of the steps. Requires LitStep::period in [0, periods). Errors: options.bin not
/// in [0, 30].
EnergyLight energy_light(std::span<const LitStep> steps, int periods, const EnergyLightOptions& options);

}  // namespace alidade::visibility
