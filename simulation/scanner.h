// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

namespace alidade {

/// Where a terrestrial scanner stands: centre of its mirror, world coordinates.
struct Station {
  glm::dvec3 position{0.0};
};

/// A terrestrial laser scanner: the mirror turns about a level axis while the head turns about the vertical
/// one, so beams form a raster of equal steps in azimuth (columns, all round) and elevation (rows).
struct TerrestrialScanner {
  double elevation_min = -60.0;  ///< degrees; below it the tripod hides the ground
  double elevation_max = 90.0;   ///< degrees
  double range_min = 0.5;        ///< metres
  double range_max = 120.0;      ///< metres
  double range_noise = 0.0015;   ///< standard deviation along the beam, metres
  double seconds = 180.0;        ///< duration of one scan
};

/// A straight flight line. The scanner's mirror turns about the axis of flight and sweeps beams across to
/// both sides of a plane that looks straight down, or ahead by `pitch`.
struct FlightLine {
  glm::dvec3 start{0.0}, end{0.0};  ///< world; at one height, apart
  double pitch = 0.0;               ///< degrees ahead of straight down, (-80, 80)
  double field_of_view = 50.0;      ///< of a sweep from side to side, degrees, (0, 160)
};

struct DroneScanner {
  double range_max = 250.0;    ///< metres
  double range_noise = 0.006;  ///< standard deviation along the beam, metres
  double speed = 6.0;          ///< metres per second
};

}  // namespace alidade
