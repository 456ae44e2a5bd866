// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "visibility/lines/line_curve.h"

// The free share of a radio link's first Fresnel zone. The zone consists of the points whose distances
// to both ends add up to at most half a wavelength more than the length of the link. With wavelength w
// and length L its radius t from an end is sqrt(w t (L - t) / L), at most sqrt(w L) / 2 in the middle.
// Source: ITU-R P.526, "Fresnel ellipsoids". The usual criterion: a link is clear if 60 % of the
// radius is free (ITU-R P.530).
//
// The zone is filled with 512 tubes: lines from end to end at a constant share of its radius and a
// constant direction around the middle, spread so that each represents the same area of every
// cross-section (Vogel's spiral, A better way to construct the sunflower head, 1979). A tube is
// obstructed if it crosses an occluder. So the edge of a half plane through the axis obstructs half of
// the zone, and one at 60 % of the radius the segment of the circle beyond it, 14.2 %; ground below a
// link obstructs the part that dips into it.

namespace alidade::visibility {

/// Metres per second, in vacuum; 0.03 % less in air.
constexpr double k_speed_of_light = 299'792'458.0;

/// Largest radius of the first zone, in the middle of a link. Both in the unit of the result.
double fresnel_radius(double wavelength, double length);

/// Share of the radius that must be free.
constexpr double k_clear_share = 0.6;

/// Number of tubes that fill the zone, and so the largest number of obstructions.
constexpr int k_most_obstructions = 512;

/// A point, or the mesh or terrain, and the share of the zone that it is the first to obstruct.
struct Obstruction {
  std::uint64_t point_id = 0;  ///< or k_mesh_blocker
  double share = 0.0;
};

struct FresnelClearance {
  double radius = 0.0;      ///< of the zone in the middle of the link, metres
  double obstructed = 0.0;  ///< share of the tubes that are obstructed, 0 .. 1
  /// A tube is cut off from both ends between its first and its last crossing. This is the largest share of
  /// tubes that are cut off within one stretch as long as the zone is wide, and where that is, metres along
  /// the chord: near `obstructed` for one wall, smaller for obstacles apart from each other.
  double worst = 0.0, worst_t = 0.0;
  /// Share of the zone's volume that is cut off in this way: the mean over its
  /// cross-sections, weighted by area.
  double cut_off = 0.0;
  double inner = 0.0;  ///< share of the tubes within 60 % of the radius that are obstructed
  /// Whether nothing is within 60 % of the radius: no point, and no obstructed tube, including the middle
  /// line and 64 more tubes at 60 %.
  bool is_clear = true;
  /// The point nearest to the middle line as a share of the zone's radius there, and this share; empty if no
  /// point lies in the zone.
  std::optional<LinePoint> nearest{};
  double nearest_share = 0.0;
  std::uint64_t points = 0;                 ///< in the zone
  std::vector<Obstruction> obstructions{};  ///< by share, the largest first, then by id
};

/// The first Fresnel zone around a line. Wavelength: metres. Cost: some 10^4 short sight lines.
/// Errors: wavelength not above 0 or not finite; occluders with a transparency above 1, since
/// every crossing obstructs.
FresnelClearance fresnel_clearance(const Occluders& occluders, const SightEnd& from, const SightEnd& to,
                                   const LineOptions& options, double wavelength);

/// Hertz of "5.8GHz", "868MHz", "2.4": a number and a unit, in upper or lower case, with or without blanks
/// between; GHz if there is no unit. Empty for anything else and outside of 1 MHz to 1000 GHz.
std::optional<double> parse_frequency(std::string_view text);

}  // namespace alidade::visibility
