// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace alidade {

/// The sun in the middle of a step.
struct SunStep {
  double azimuth = 0.0;     ///< degrees clockwise from +y, [0, 360)
  double elevation = 0.0;   ///< degrees above the horizon, as seen through the air, > 0
  double hours = 0.0;       ///< how long the step is
  double irradiance = 0.0;  ///< beam_irradiance(), W/m2
};

/// Steps in which the sun stands in about the same direction, taken as one.
struct SunBin {
  glm::dvec3 direction{0.0, 0.0, 1.0};  ///< the middle of the steps' directions, weighed by their hours
  double hours = 0.0;
  /// Sum of hours times irradiance times direction of the steps, Wh/m2: its product with a receiver's normal
  /// is what the receiver gets. Exact as long as the receiver faces all of the steps.
  glm::dvec3 energy{0.0};
};

/// Groups steps by bins of so many degrees of elevation and, at the horizon, azimuth (wider further up, so
/// that all bins are about as large). A bin's edges of light and shade are those of its middle: a shadow
/// comes or goes wrong by at most half a bin in some of its steps, late in as many as early. A year's steps,
/// 10 minutes apart, lie in some 1000 bins of 3 degrees. With 0 every step is its own bin. Errors: not in [0,
/// 30].
std::vector<SunBin> sun_bins(std::span<const SunStep> steps, double degrees);

}  // namespace alidade
