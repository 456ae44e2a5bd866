// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "visibility/horizon/horizon.h"
#include "visibility/sight_line.h"

namespace alidade::visibility {

constexpr int k_most_sky_directions = 1 << 20;

/// Directions to the sky, spread evenly over the upper hemisphere, each for 1/count of its solid angle: the
/// i-th at sin(elevation) = (i + 1/2) / count, each turned by the golden angle from the one before. The same
/// bits on every machine. Source: Gonzalez, Measurement of Areas on a Sphere Using Fibonacci and
/// Latitude-Longitude Lattices, 2010. Requires 1 <= count <= k_most_sky_directions.
std::vector<glm::dvec3> even_sky_directions(int count);

/// As even_sky_directions(), but with a density proportional to sin(elevation), so that
/// each represents 1/count of the light that an even sky sends to a horizontal receiver:
/// sin^2(elevation) = 1 - (i + 1/2) / count. Source: the projection of the hemisphere
/// onto its base, Nusselt 1928.
std::vector<glm::dvec3> cosine_sky_directions(int count);

/// A part of the sky between two azimuths and two elevations, degrees; azimuths as those of SunStep,
/// min < max.
struct SkyCell {
  double azimuth_min = 0.0, azimuth_max = 360.0, elevation_min = 0.0, elevation_max = 90.0;
};

/// The integral of the direction over the solid angle of a cell. Its product with the cell's radiance and the
/// normal of a receiver that faces all of the cell is the irradiance of that receiver.
glm::dvec3 direction_integral(const SkyCell& cell);

// The share of the sky that is visible from a position, through every gap.
//
//   std::vector<SkyTarget> targets{target_on_point(occluders, id, position, {})};
//   std::vector<float> views(1);
//   sky_views(occluders, targets, {}, views);

/// A position from which the sky is seen.
struct SkyTarget {
  /// Where its lines start: those on the side of its surface that `normal` points to, and the others.
  SightEnd front, back;
  glm::dvec3 normal{0.0};  ///< of length 1; zero: it is on no surface and sees in all directions
  /// Whether the front is known to be the outside, so that the back sees nothing.
  bool is_front_open = false;

  bool has_surface() const { return normal != glm::dvec3(0.0); }
};

/// A point of the cloud. `outward`, if given, points to the outside of its surface (not zero, of any length).
SkyTarget target_on_point(const Occluders& occluders, std::uint64_t point_id, const glm::dvec3& position,
                          const std::optional<glm::dvec3>& outward);

/// A position on or above the ground, which sees in all directions.
SkyTarget target_in_open(const SightEnd& end);

/// Whether horizons can replace lines of sight: nothing but a terrain blocks, at any distance. In an azimuth,
/// every line below one that meets a terrain meets it or is below it.
bool has_horizons(const Occluders& occluders, double max_distance);

/// The slope above which light from an azimuth (a horizontal direction of length 1) comes from the front of a
/// surface with this normal, z >= 0; infinite: none does.
double facing_slope(const glm::dvec3& normal, const glm::dvec2& direction);

enum class SkyReceiver {
  horizontal,  ///< faces up: light from straight above counts most
  surface,     ///< faces as the surface; up if the target has none
};

struct SkyViewOptions {
  int directions = 128;  ///< lines per target, 1 .. k_most_sky_directions
  SkyReceiver receiver = SkyReceiver::surface;
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
};

/// Sky-view factor of every target: 1/pi times the integral, over the solid angle of the sky that it
/// sees, of the cosine to the receiver's normal, where that is above 0. 1: all of the sky, face up; an
/// open wall has 1/2, an open slope of inclination b (1 + cos b) / 2. The sky consists of the directions
/// above the horizontal; a surface hides the half behind it, also from a horizontal receiver. If
/// SkyTarget::is_front_open is set, that is the half at the back; else the value is that of the side
/// that sees more. So both sides of a wall that was scanned on both are correct, and of a scanned roof
/// the inside does not count.
///
/// Quadrature: `directions` lines; for horizontal receivers in cosine_sky_directions(), equally
/// weighted, else in even_sky_directions() with the cosine as weight. Of 128 lines the error between
/// walls is 0.01 (standard deviation over street canyons of all widths and directions, 0.03 at most); it
/// halves with 2.5 times as many. Lines start at the target's ends (sight_line.h). Sources: Johnson and
/// Watson, The Determination of View-Factors in Urban Canyons, 1984; for slopes Dozier and Frew, Rapid
/// Calculation of Terrain Parameters for Radiation Modeling From Digital Elevation Data, 1990. Errors:
/// number of directions out of range; max_distance negative or NaN. Requires as many views as targets. Cost:
/// a line per target and direction, in parallel; fast if neighbours among the targets are neighbours in
/// space, in batches of 10^4 to 10^5. With has_horizons(): a horizon in each of `directions` even azimuths
/// instead, and the integral above it: the error is that of the azimuths alone.
void sky_views(const Occluders& occluders, std::span<const SkyTarget> targets, const SkyViewOptions& options,
               std::span<float> views);

/// Turns every target that has a surface and no is_front_open so that its front is the side with the larger
/// sky-view factor (SkyReceiver::surface, of `directions` lines), or at equal values, and for surfaces within
/// 20 degrees of the horizontal, the side that faces up, and sets is_front_open. For a wall that stands alone
/// and was scanned from one side, both sides see as much sky: only normals can decide.
void find_open_sides(const Occluders& occluders, int directions, std::span<SkyTarget> targets);

/// Both shares of the sky that an eye sees, including gaps below its horizon line, with `directions` lines
/// each. Errors: as sky_views().
SkyShares sky_shares(const Occluders& occluders, const SightEnd& eye, int directions,
                     double max_distance = std::numeric_limits<double>::infinity());

}  // namespace alidade::visibility
