// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "visibility/horizon/skyline.h"
#include "visibility/sky/sun_path.h"

namespace alidade::visibility {

/// The path of the sun on the longest, the shortest and an even day of the year in which a schedule begins (21 June, 20
/// March, 21 December), with their dates as labels, and behind them a line for every whole hour of mean solar time, from
/// the shortest to the longest day, named where it meets the first path. Only what is above the horizontal. Cost: a
/// second's twentieth. Errors: as sun_steps().
std::vector<SkylineCurve> sun_curves(const SunSchedule& schedule);

}  // namespace alidade::visibility
