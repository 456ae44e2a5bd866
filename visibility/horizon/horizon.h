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

// From one position, all directions: how high what stands around it reaches.
//
//   const SightEnd eye = end_near_surface(occluders, {690010, 5325020, 583.7});
//   const std::vector<HorizonDirection> line = horizon(occluders, eye, {});
//   const SkyShares sky = sky_above(line);
//
// In every azimuth lines of sight go out at the elevations k * resolution, for whole numbers k. The horizon
// is the highest of them that is blocked: all lines above it are free, and the edge of what blocks lies less
// than one resolution above. What is thinner than that and stands free above the rest (a wire) can fall
// between two lines. Below the horizon line may be sky as well: under bridges and branches.

namespace alidade::visibility {

struct HorizonOptions {
  double step = 0.5;         ///< degrees between azimuths; a turn is a whole number of them; [0.001, 120]
  double resolution = 0.01;  ///< degrees between elevations; 90 is a whole number of them; [0.0001, 10]
  /// Azimuths examined, degrees clockwise from north, from the first limit on to the second, both inclusive:
  /// multiples of the step. 0 to 360 is all round, each once.
  double azimuth_min = 0.0, azimuth_max = 360.0;
  double elevation_min = -90.0, elevation_max = 90.0;             ///< examined, degrees, inclusive
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
};

/// How many azimuths a turn has at this step. Errors: as HorizonOptions::step has it.
int azimuths_per_turn(double step);

/// What one sees of the horizon in one azimuth.
struct HorizonDirection {
  double azimuth = 0.0;               ///< degrees clockwise from north (+y), [0, 360)
  std::optional<double> elevation{};  ///< degrees above the horizontal; empty if nothing blocks any line
  std::optional<Blocker> blocker{};   ///< what first blocks the line at that elevation
  /// Length of the line over unscanned ground, up to the blocker (unscanned_length() of raster/ground.h). Set by
  /// callers that have the ground.
  std::optional<double> unscanned{};
};

/// The horizon, azimuth by azimuth clockwise from azimuth_min. Errors: options out of range. Memory: at most 110 MB.
/// Cost: 0.3 microseconds of one thread per point for a table of what comes near any line; of the lines that it does
/// not call free, and that no triangle or patch of terrain is near to, those from the highest blocked one on: 10 to
/// 10^3 per azimuth, in parallel. `progress` is in azimuths. The same on any number of threads and any instruction set.
std::vector<HorizonDirection> horizon(const Occluders& occluders, const SightEnd& eye,
                                      const HorizonOptions& options, const Progress& progress = {});

/// How much of the sky one sees, 0 to 1.
struct SkyShares {
  /// Light of an even sky on a horizontal receiver, as a share of that of the open sky:
  /// 1/pi times the integral of sin(elevation) over the solid angle of the sky seen.
  double cosine_weighted = 1.0;
  double solid_angle = 1.0;  ///< of the sky seen, as a share of the hemisphere's 2 pi
};

/// The sky above a horizon line that goes all round, taking all below the line as blocked: with h the
/// elevation in each of n even azimuths (0 if it is lower or empty), the means of cos^2 h and of 1 - sin h.
/// Sources: the first is Steyn, The calculation of view factors from fisheye-lens photographs, 1980, with
/// even azimuths for his annuli; the second Zaksek, Ostir, Kokalj, Sky-View Factor as a Relief Visualization
/// Technique, 2011, equation 4. Requires at least one direction.
SkyShares sky_above(std::span<const HorizonDirection> horizon);

/// What a file says beside the line itself.
struct HorizonFacts {
  glm::dvec3 eye{0.0};
  std::optional<SkyShares> above_line;  ///< sky_above(); empty of a line that does not go all round
  SkyShares sky;                        ///< sky_shares()
};

/// The line as CSV with a line of names: azimuth, elevation (degrees), distance (along the line of sight, in
/// the cloud's unit), point_id, x, y, z of that point, unscanned; of a mesh or terrain point_id is empty, and x, y, z
/// are where the line meets it. Cells of azimuths without a horizon are empty.
std::string horizon_csv(std::span<const HorizonDirection> horizon);

/// The positions that horizon_geojson() wants longitude and latitude of (lon_lat.h): the blocking points, in
/// order, azimuths without one left out, then the eye.
std::vector<glm::dvec3> horizon_positions(std::span<const HorizonDirection> horizon,
                                          const HorizonFacts& facts);

/// The line as GeoJSON (RFC 7946): the observer, with the sky-view factors, and every blocking point with
/// azimuth, elevation, distance, point_id (null: mesh or terrain) and z, as points; azimuths without a horizon have
/// no geometry.
/// Without longitudes and latitudes the coordinates are the cloud's, and a member "coordinate_system" of the
/// collection says so.
std::string horizon_geojson(std::span<const HorizonDirection> horizon, const HorizonFacts& facts,
                            const std::optional<std::vector<glm::dvec3>>& on_globe);

}  // namespace alidade::visibility
