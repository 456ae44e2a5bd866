// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "visibility/lines/line_curve.h"

// How much of a radio link's first Fresnel zone is free. The zone are the positions from which the way over
// both ends is at most half a wavelength longer than the straight one; a link with wavelength w and length L
// has there, t from an end, the radius sqrt(w t (L - t) / L), at most sqrt(w L) / 2 in the middle. Source:
// ITU-R P.526, "Fresnel ellipsoids". The usual verdict: a link is clear if 60 % of the radius are (ITU-R
// P.530).
//
// The zone is filled with 512 tubes: lines from end to end that keep their share of its radius and their
// direction around the middle, spread so that each represents the same area of every cross-section (Vogel's
// spiral, A better way to construct the sunflower head, 1979). A tube is obstructed if it crosses an
// occluder. So the edge of a half plane through the axis obstructs half of the zone, and one at 60 % of the
// radius the segment of the circle beyond it, 14.2 %; ground below a link obstructs what dips into it.

namespace alidade::visibility {

/// Metres per second, in vacuum; air takes 0.03 % off.
constexpr double k_speed_of_light = 299'792'458.0;

/// Largest radius of the first zone, in the middle of a link. Both in the unit of the result.
double fresnel_radius(double wavelength, double length);

/// Share of the radius that has to be free.
constexpr double k_clear_share = 0.6;

/// Tubes that fill the zone, and so the most blockers that are the first to obstruct one.
constexpr int k_most_obstructions = 512;

/// A point, or the mesh or terrain, and the share of the zone that it is the first to obstruct.
struct Obstruction {
  std::uint64_t point_id = 0;  ///< or k_mesh_blocker
  double share = 0.0;
};

struct FresnelClearance {
  double radius = 0.0;      ///< of the zone in the middle of the link, metres
  double obstructed = 0.0;  ///< share of the tubes that are obstructed, 0 .. 1
  /// A tube is cut off from both ends between its first and its last crossing. The largest share of the tubes
  /// that are cut off within any stretch as long as the zone is wide, and where it is reached, metres along
  /// the chord: near `obstructed` for one wall, smaller for obstacles apart from each other.
  double worst = 0.0, worst_t = 0.0;
  /// Share of the zone's volume that is cut off so: the mean over its cross-sections, each by its area.
  double cut_off = 0.0;
  double inner = 0.0;  ///< share of the tubes within 60 % of the radius that are obstructed
  /// Whether nothing is within 60 % of the radius: no obstructed tube, of 64 more on its rim and the middle
  /// line as well, and no point.
  bool is_clear = true;
  /// The point nearest to the middle line as a share of the zone's radius there, and this share; empty if no
  /// point lies in the zone.
  std::optional<LinePoint> nearest{};
  double nearest_share = 0.0;
  std::uint64_t points = 0;                 ///< in the zone
  std::vector<Obstruction> obstructions{};  ///< by share, the largest first, then by id
};

/// The first Fresnel zone around a line. Wavelength: metres. Cost: some 10^4 short sight lines. Errors:
/// wavelength not above 0 or not finite; occluders with a transparency above 1, since every crossing
/// obstructs.
FresnelClearance fresnel_clearance(const Occluders& occluders, const SightEnd& from, const SightEnd& to,
                                   const LineOptions& options, double wavelength);

/// Hertz of "5.8GHz", "868MHz", "2.4": a number with its unit, in any case of characters and with blanks
/// between or not; GHz without one. Empty for anything else and outside of 1 MHz to 1000 GHz.
std::optional<double> parse_frequency(std::string_view text);

}  // namespace alidade::visibility
