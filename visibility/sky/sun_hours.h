// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "visibility/sky/sky_view.h"
#include "visibility/sky/sun_bins.h"

namespace alidade {

/// What a place gets from the sun's disc, under a clear sky.
struct SunHours {
  float hours = 0.0f;           ///< of direct sun
  float kilowatt_hours = 0.0f;  ///< per m2 of the receiver: beam_irradiance() times the cosine of incidence
};

struct SunHoursOptions {
  SkyReceiver receiver = SkyReceiver::surface;
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
};

/// Direct sun of every target: a line towards the middle of each bin (sun_bins.h) that no point blocks. The
/// sun is a point, and stands behind a surface or before it: call find_open_sides() first, of targets that do
/// not know their outside the front is taken. Hours count while the sun is before the surface, also for a
/// horizontal receiver. Results do not depend on threads or instruction set. Errors: as many answers as
/// targets. Cost: a line per target and bin, in parallel; targets in the order of the octree are fast.
void sun_hours(const Occluders& occluders, std::span<const SkyTarget> targets, std::span<const SunBin> bins,
               const SunHoursOptions& options, std::span<SunHours> answers);

}  // namespace alidade
