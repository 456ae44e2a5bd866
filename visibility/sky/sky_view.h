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

/// The same with a density that goes with sin(elevation), so that each represents 1/count of the light that
/// an even sky sends to a horizontal receiver: sin^2(elevation) = 1 - (i + 1/2) / count. Source: the
/// projection of the hemisphere onto its base, Nusselt 1928.
std::vector<glm::dvec3> cosine_sky_directions(int count);

// How much of the sky a position sees, through every gap that is there.
//
//   std::vector<SkyTarget> targets{target_on_point(occluders, id, position, {})};
//   std::vector<float> views(1);
//   sky_views(occluders, targets, {}, views);

/// A position that looks at the sky.
struct SkyTarget {
  /// Where its lines start: those towards the side of its surface that `normal` points to, and the others.
  SightEnd front, back;
  glm::dvec3 normal{0.0};  ///< unit; zero: it lies on no surface and sees to all sides
  bool is_front_open =
      false;  ///< whether the front is known to be the outside, so that the back sees nothing

  bool has_surface() const { return normal != glm::dvec3(0.0); }
};

/// A point of the cloud. `outward`, if given, says which side of its surface is the outside: the one on which
/// it lies (not zero, of any length).
SkyTarget target_on_point(const Occluders& occluders, std::uint64_t point_id, const glm::dvec3& position,
                          const std::optional<glm::dvec3>& outward);

/// A position on or above the ground, which looks to all sides.
SkyTarget target_in_open(const SightEnd& end);

/// Whether horizons can replace lines of sight: a terrain alone blocks, whatever its distance. Below a line that meets
/// it every line of the azimuth meets it or goes below it.
bool has_horizons(const Occluders& occluders, double max_distance);

/// The slope above which light from an azimuth (a horizontal direction of length 1) comes from before a surface with
/// this normal, z >= 0; infinite: none does.
double facing_slope(const glm::dvec3& normal, const glm::dvec2& direction);

enum class SkyReceiver {
  horizontal,  ///< faces up: light from straight above counts most
  surface,     ///< faces where the surface does; of a target without a surface, up
};

struct SkyViewOptions {
  int directions = 128;  ///< lines per target, 1 .. k_most_sky_directions
  SkyReceiver receiver = SkyReceiver::surface;
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
};

/// Sky-view factor of every target: 1/pi times the integral, over the solid angle of the sky that it sees, of
/// the cosine to the receiver's normal, where that is above 0. 1: all of the sky, face up; an open wall has
/// 1/2, an open slope of inclination b (1 + cos b) / 2. Sky are the directions above the horizontal; a
/// surface shuts the half behind it, also for a horizontal receiver. Which half that is: the one that
/// SkyTarget::is_front_open says; else the value is that of the side which sees more. So both sides of a
/// wall that was scanned on both count rightly, and the inside of a house whose roof was scanned loses.
///
/// Quadrature: `directions` lines; for horizontal receivers in cosine_sky_directions(), equally weighted,
/// else in even_sky_directions() with the cosine as weight. Of 128 lines the error between walls is 0.01
/// (standard deviation over street canyons of all widths and directions, 0.03 at most); it halves with 2.5
/// times as many. Lines start at the target's own ends, see sight_line.h. Sources: Johnson and Watson, The
/// Determination of View-Factors in Urban Canyons, 1984; for slopes Dozier and Frew, Rapid Calculation of
/// Terrain Parameters for Radiation Modeling From Digital Elevation Data, 1990. Errors: options out of range;
/// as many views as targets. Cost: a line per target and direction, in parallel; fast if neighbours among the
/// targets are neighbours in space, in batches of 10^4 to 10^5. With has_horizons(): a horizon in each of `directions`
/// even azimuths instead, and the integral above it: the error is that of the azimuths alone.
void sky_views(const Occluders& occluders, std::span<const SkyTarget> targets, const SkyViewOptions& options,
               std::span<float> views);

/// Turns every target that does not know its outside so that its front is the side with the larger sky-view
/// factor (SkyReceiver::surface, of `directions` lines); at equal values, and of surfaces that lie within 20
/// degrees of the horizontal, the one that faces up. The single sheet of a lone wall that was scanned from
/// one side sees as much sky on either: only normals decide.
void find_open_sides(const Occluders& occluders, int directions, std::span<SkyTarget> targets);

/// Both shares of the sky that a position sees, gaps below its horizon line counting too: of `directions` lines
/// each. Errors: as sky_views.
SkyShares sky_shares(const Occluders& occluders, const SightEnd& eye, int directions,
                     double max_distance = std::numeric_limits<double>::infinity());

}  // namespace alidade::visibility
