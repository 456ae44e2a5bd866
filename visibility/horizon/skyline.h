// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "visibility/horizon/horizon.h"

namespace alidade {

/// Distances over a part of the view from a place, pixel by pixel, row 0 on top. Column x of it looks to
/// azimuth_min + (x + 1/2) / width of the range of azimuths, rows likewise down from elevation_max.
struct DepthStrip {
  int width = 0, height = 0;
  double azimuth_min = 0.0, azimuth_max = 360.0;  ///< degrees, azimuth_min < azimuth_max <= azimuth_min + 360
  double elevation_min = 0.0, elevation_max = 90.0;  ///< degrees
  std::vector<float> distances;                      ///< metres; infinity: sky
};

/// A strip of the right size and range of elevations for the skyline of this horizon: its line, with some
/// room above and below. `distances` is empty.
DepthStrip strip_around(std::span<const HorizonDirection> horizon, double azimuth_min, double azimuth_max);

/// Fills in the distances: a line per pixel, in parallel. `progress` is in pixels.
void fill_strip(const Occluders& occluders, const SightEnd& eye, double max_distance, DepthStrip& strip,
                const Progress& progress = {});

/// What stands around the picture.
struct SkylineTexts {
  std::string title;  ///< above it
  std::string note;   ///< below it
  std::string unit;   ///< of distances: "m"; empty if it is not known
};

}  // namespace alidade
