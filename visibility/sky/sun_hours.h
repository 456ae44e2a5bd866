// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "visibility/sky/sky_view.h"

namespace alidade::visibility {

/// The sun in the middle of a step.
struct SunStep {
  double azimuth = 0.0;     ///< degrees clockwise from +y, [0, 360)
  double elevation = 0.0;   ///< degrees above the horizon, as seen through the air, > 0
  double hours = 0.0;       ///< how long the step is
  double irradiance = 0.0;  ///< beam_irradiance(), W/m2
};

/// Steps in which the sun is in about the same direction, taken as one.
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

/// What a position gets from the sun's disc, under a clear sky.
struct SunHours {
  float hours = 0.0f;           ///< of direct sun
  float kilowatt_hours = 0.0f;  ///< per m2 of the receiver: beam_irradiance() times the cosine of incidence
};

struct SunHoursOptions {
  SkyReceiver receiver = SkyReceiver::surface;
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
};

/// Direct sun of every target: a line towards the middle of each bin (sun_bins.h) that no point blocks. The
/// sun is a point, and is behind a surface or before it: call find_open_sides() first, of targets that do
/// not know their outside the front is taken. Hours count while the sun is before the surface, also for a
/// horizontal receiver. Results do not depend on threads or instruction set. Errors: as many answers as
/// targets. Cost: a line per target and bin, in parallel; targets in the order of the octree are fast.
void sun_hours(const Occluders& occluders, std::span<const SkyTarget> targets, std::span<const SunBin> bins,
               const SunHoursOptions& options, std::span<SunHours> answers);

}  // namespace alidade::visibility
