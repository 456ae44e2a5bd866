// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "visibility/sky/sun_path.h"

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

/// Light from a narrow range of directions. One line of sight decides whether a receiver gets it.
struct LightBin {
  /// Of the line: the unit mean of the sun's directions, weighted by hours; for the sky line_into_patch().
  glm::dvec3 direction{0.0, 0.0, 1.0};
  struct Share {
    int period = 0;  ///< SunStep::period
    LightSums sums;
  };
  std::vector<Share> shares;  ///< in the order of periods
};

/// Light from a narrow range of azimuths, at all elevations; a horizon hides the part below it.
struct LightFan {
  glm::dvec2 direction{0.0, 1.0};  ///< horizontal unit vector
  struct Share {
    int period = 0;               ///< SunStep::period
    std::vector<double> slopes;   ///< tangents of the elevations of the light, descending
    std::vector<LightSums> sums;  ///< sums[i]: of the first i slopes; one element more than slopes
  };
  std::vector<Share> shares;  ///< in the order of periods
};

struct LightOptions {
  double bin = 0.0;          ///< width of bins and fans, degrees, [0, 30]; 0: one for each step of the sun
  bool has_sky = true;       ///< whether to add the diffuse light of the sky to that of the sun's disc
  bool by_horizons = false;  ///< fans, for receivers with horizons, instead of bins
};

/// The light of a time range, in bins or in fans.
struct SunLight {
  int periods = 1;             ///< number of them
  std::vector<LightBin> bins;  ///< empty with LightOptions::by_horizons
  std::vector<LightFan> fans;  ///< empty without
  /// Without obstructions, by period: the z of an energy is what open level ground gets.
  std::vector<LightSums> open;
};

/// Direction of the line of sight that represents a patch of the sky (sky_patches.h). The elevations differ
/// along a row of patches, so that a level edge hides the same share of the lines as of the row. Requires
/// 0 <= patch < k_sky_patches.
glm::dvec3 line_into_patch(int patch);

/// Groups the light of the sun's steps, and of the sky during them, by direction.
///
/// Bins span `options.bin` degrees of elevation and, at the horizon, of azimuth; further up they span more
/// azimuth, so that all have about the same size. The middle of a bin decides whether its light is hidden:
/// shadows begin and end up to half a bin too early or too late, equally often. The steps of a year, 10
/// minutes apart, fill some 1000 bins of 3 degrees. Fans span `options.bin` degrees of azimuth; their
/// elevations are exact.
///
/// The sky is the cumulative sky of sky_patches.h: the radiances of each patch are summed over the steps. The
/// light of each of the 145 patches is a bin in the direction of line_into_patch(). For fans, the sky
/// consists of cells: 1 degree of elevation by `options.bin` degrees of azimuth, at most 2 (2 if it is 0).
/// Patches, lines and cells preserve the integral of direction over solid angle: open level ground gets
/// exactly the diffuse energy of the steps. Requires SunStep::period in [0, periods). Errors: options.bin not
/// in [0, 30].
SunLight sun_light(std::span<const SunStep> steps, int periods, const LightOptions& options);

}  // namespace alidade::visibility
