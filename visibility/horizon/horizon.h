// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/progress.h"
#include "visibility/sight_line.h"

// The horizon line around an eye: in every direction, the elevation up to which something blocks the view.
//
//   const SightEnd eye = end_near_surface(occluders, {690010, 5325020, 583.7});
//   const std::vector<HorizonDirection> line = horizon(occluders, eye, {});
//   const SkyShares sky = sky_above(line);
//
// In every azimuth lines of sight go out at the elevations k * resolution, for whole numbers k. The horizon
// is the highest of them that is blocked: all lines above it are free, and the edge of the blocker is less
// than one resolution above. Something thinner than that and free above the rest (a wire) can be missed
// between two lines. There may be sky below the horizon line as well: under bridges and branches.

namespace alidade::visibility {

struct HorizonOptions {
  double step = 0.5;         ///< degrees between azimuths, divides 360; [0.001, 120]
  double resolution = 0.01;  ///< degrees between elevations, divides 90; [0.0001, 10]
  /// Azimuths examined, degrees clockwise from north, from the first limit on to the second, both inclusive:
  /// multiples of the step. 0 to 360 is the full circle, each azimuth once.
  double azimuth_min = 0.0, azimuth_max = 360.0;
  double elevation_min = -90.0, elevation_max = 90.0;             ///< examined, degrees, inclusive
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
};

/// Number of azimuths in a turn with this step. Errors: those of HorizonOptions::step.
int azimuths_per_turn(double step);

/// The horizon in one azimuth.
struct HorizonDirection {
  double azimuth = 0.0;               ///< degrees clockwise from north (+y), [0, 360)
  std::optional<double> elevation{};  ///< degrees above the horizontal; empty if nothing blocks any line
  std::optional<Blocker> blocker{};   ///< what first blocks the line at that elevation
  /// Length of the line over unscanned ground, up to the blocker (unscanned_length() of raster/ground.h). Set
  /// by callers that have the ground.
  std::optional<double> unscanned{};
};

/// The horizon, azimuth by azimuth clockwise from azimuth_min. Errors: options out of range. Memory: at most
/// 110 MB. Cost: 0.3 microseconds of one thread per point for a table of the lines that may be blocked; then
/// 10 to 10^3 lines of sight per azimuth, in parallel: those from the highest blocked one on that neither the
/// table nor the boxes of triangles and terrain show to be free. `progress` is in azimuths. The same on any
/// number of threads and any instruction set.
std::vector<HorizonDirection> horizon(const Occluders& occluders, const SightEnd& eye,
                                      const HorizonOptions& options, const Progress& progress = {});

/// Visible shares of the sky, 0 to 1.
struct SkyShares {
  /// Light of an even sky on a horizontal receiver, as a share of that of the open sky:
  /// 1/pi times the integral of sin(elevation) over the solid angle of the sky seen.
  double cosine_weighted = 1.0;
  double solid_angle = 1.0;  ///< of the sky seen, divided by the 2 pi of the hemisphere
};

/// The sky above a horizon line of a full circle, if everything below the line is blocked: with h the
/// elevation in each of n even azimuths (0 if it is lower or empty), the means of cos^2 h and of 1 - sin h.
/// Sources: the first is Steyn, The calculation of view factors from fisheye-lens photographs, 1980, with
/// even azimuths for his annuli; the second Zaksek, Ostir, Kokalj, Sky-View Factor as a Relief Visualization
/// Technique, 2011, equation 4. Requires at least one direction.
SkyShares sky_above(std::span<const HorizonDirection> horizon);

/// What a file holds beside the line itself.
struct HorizonFacts {
  glm::dvec3 eye{0.0};
  std::optional<SkyShares> above_line;  ///< sky_above(); empty if the line is not a full circle
  SkyShares sky;                        ///< sky_shares()
};

/// The line as CSV with a header: azimuth, elevation (degrees), distance (along the line of sight, in the
/// cloud's unit), point_id, x, y, z of that point, unscanned; for a mesh or terrain point_id is empty, and x,
/// y, z are where the line meets it. Cells of azimuths without a horizon are empty.
std::string horizon_csv(std::span<const HorizonDirection> horizon);

/// The positions for whose longitudes and latitudes horizon_geojson() has a parameter: the blocking points,
/// in order, azimuths without one left out, then the eye.
std::vector<glm::dvec3> horizon_positions(std::span<const HorizonDirection> horizon,
                                          const HorizonFacts& facts);

/// The line as GeoJSON (RFC 7946): the observer, with the sky-view factors, and every blocking point with
/// azimuth, elevation, distance, point_id (null: mesh or terrain) and z, as points; azimuths without a
/// horizon have no geometry. Without longitudes and latitudes the coordinates are the cloud's, as a member
/// "coordinate_system" of the collection states.
std::string horizon_geojson(std::span<const HorizonDirection> horizon, const HorizonFacts& facts,
                            const std::optional<std::vector<glm::dvec3>>& on_globe);

}  // namespace alidade::visibility
