// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "base/progress.h"
#include "image/film.h"
#include "visibility/horizon/horizon.h"
#include "visibility/sight_line.h"

namespace alidade::visibility {

/// Everything around an eye as distances: the layers depth, distance (equal, as a panorama has no axis) and
/// id (point id + 1) of a panorama_camera() (camera/camera.h) at the eye, whose middle column looks north.
/// Pixels without a blocker within max_distance have infinite distances and id 0, those of a mesh or terrain
/// its distance and id 0. A pixel shows the first blocker of the line through its centre (sight_line.h).
/// Requires sides of at least 1 pixel. Cost: a line per pixel, in parallel. `progress` is in pixels.
image::Film depth_panorama(const Occluders& occluders, const SightEnd& eye, int width, int height,
                           double max_distance = std::numeric_limits<double>::infinity(),
                           const Progress& progress = {});

/// Distances over a part of the view from an eye, pixel by pixel, row 0 on top. Column x looks to
/// azimuth_min + (x + 1/2) / width of the range of azimuths, rows likewise down from elevation_max.
struct DepthStrip {
  int width = 0, height = 0;
  double azimuth_min = 0.0, azimuth_max = 360.0;  ///< degrees, azimuth_min < azimuth_max <= azimuth_min + 360
  double elevation_min = 0.0, elevation_max = 90.0;  ///< degrees
  std::vector<float> distances;                      ///< metres; infinity: sky
};

/// A strip of the right size and range of elevations for the skyline of this horizon: it shows the line and
/// elevations up to `highest` degrees, with some room above and below. `distances` is empty.
DepthStrip strip_around(std::span<const HorizonDirection> horizon, double azimuth_min, double azimuth_max,
                        double highest = 0.0);

/// Fills in the distances: a line per pixel, in parallel. `progress` is in pixels.
void fill_strip(const Occluders& occluders, const SightEnd& eye, double max_distance, DepthStrip& strip,
                const Progress& progress = {});

}  // namespace alidade::visibility
