// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "visibility/sky/sun_path.h"

// The light of a time range by direction, prepared for many receivers.

namespace alidade::visibility {

/// Sums over time. The product of an energy and the normal of a receiver is what the receiver gets, Wh/m2;
/// exact if it faces all of the light.
struct LightSums {
  double hours = 0.0;                  ///< of direct sun
  glm::dvec3 beam{0.0}, diffuse{0.0};  ///< of the sun's disc, of the sky, Wh/m2

  LightSums& operator+=(const LightSums& other) {
    hours += other.hours;
    beam += other.beam;
    diffuse += other.diffuse;
    return *this;
  }
};

/// Light from about one direction, which a single line of sight represents.
struct LightBin {
  glm::dvec3 direction{0.0, 0.0, 1.0};  ///< the middle of the steps' directions, weighed by their hours
  struct Share {
    int period = 0;
    LightSums sums;
  };
  std::vector<Share> shares;  ///< periods in order
};

/// Light from about one azimuth, at all elevations; a horizon hides the part below it.
struct LightFan {
  glm::dvec2 direction{0.0, 1.0};  ///< horizontal, of length 1
  struct Share {
    int period = 0;
    std::vector<double> slopes;   ///< tangents of the elevations, falling
    std::vector<LightSums> sums;  ///< of the first 0, 1, 2, ... of them
  };
  std::vector<Share> shares;
};

struct LightOptions {
  /// Degrees by which directions are grouped; 0: each step of the sun is a bin of its own.
  double bin = 0.0;
  bool has_sky = true;       ///< whether the sky gives light, or the sun's disc alone
  bool by_horizons = false;  ///< fans instead of bins
};

/// The light of a time range.
struct SunLight {
  int periods = 1;
  std::vector<LightBin> bins;  ///< of one kind
  std::vector<LightFan> fans;  ///< or of the other
  std::vector<LightSums>
      open;  ///< of each period, without obstructions: the z of energies is what open level ground gets
};

/// Direction of the line of sight that represents a patch of the sky (sky_patches.h): its elevations differ
/// along a row, so that a level edge shades as much of the row as it covers. Requires
/// 0 <= patch < k_sky_patches.
glm::dvec3 line_into_patch(int patch);

/// Sorts steps of the sun, and the sky above them, by direction.
///
/// Bins are as wide in elevation and, at the horizon, azimuth as `options.bin` (wider further up, so that all
/// are about as large). Light and shade of a bin are those of its middle: a shadow is wrong by at most half a
/// bin in some of its steps, late in as many as early. The steps of a year, 10 minutes apart, fill some 1000
/// bins of 3 degrees. Fans are as wide in azimuth; their elevations are exact.
///
/// The sky is the cumulative sky of sky_patches.h: the radiances of each patch are summed over the steps.
/// Bins of the sky are the 145 directions of line_into_patch(); fans have cells of a degree of elevation,
/// `options.bin` wide, at most 2 degrees. Patches, lines and cells preserve the integral of direction over
/// solid angle: open level ground gets exactly the diffuse energy of the steps. Requires: periods of steps in
/// [0, periods). Errors: options.bin not in [0, 30].
SunLight sun_light(std::span<const SunStep> steps, int periods, const LightOptions& options);

}  // namespace alidade::visibility
