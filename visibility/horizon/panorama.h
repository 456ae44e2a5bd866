// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "base/progress.h"
#include "image/film.h"
#include "visibility/sight_line.h"

namespace alidade {

/// Everything around an eye as distances: the layers depth, distance (equal, as a panorama has no axis) and
/// id (point id + 1) of a panorama_camera() (camera/camera.h) at the eye, whose middle column looks north.
/// Pixels that see no point within max_distance have infinite distances and id 0. A pixel shows the first
/// blocker of the line through its centre (sight_line.h). Requires sides of at least 1 pixel. Cost: a line
/// per pixel, in parallel. `progress` is in pixels.
Film depth_panorama(const Occluders& occluders, const SightEnd& eye, int width, int height,
                    double max_distance = std::numeric_limits<double>::infinity(),
                    const Progress& progress = {});

}  // namespace alidade
