// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>

#include "visibility/sky/sky_view.h"
#include "visibility/sky/sun_light.h"

namespace alidade::visibility {

/// What a receiver gets from sun and sky in a period.
struct Radiation {
  float hours = 0.0f;  ///< of direct sun
  float beam = 0.0f;   ///< Wh/m2 of the receiver, by the sun's disc: irradiance times the cosine of incidence
  float diffuse = 0.0f;    ///< Wh/m2, by the part of the sky that it sees
  float reflected = 0.0f;  ///< Wh/m2, by the ground that it faces, or by everything that it sees

  float global() const { return beam + diffuse + reflected; }
};

struct SunHoursOptions {
  SkyReceiver receiver = SkyReceiver::surface;
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
  /// Normal of every receiver, of length 1, with z >= 0, instead of that of `receiver`.
  std::optional<glm::dvec3> normal{};
  double albedo = 0.2;  ///< share of its light that the ground reflects, [0, 1]
  /// 0, or 1: light is reflected by everything that the receivers see (bounced_light.h), with one albedo.
  int bounces = 0;
  /// Every target receives as a small sphere does: a quarter of the light from each direction. For targets
  /// without a surface; does not apply to fans and to `reflected`.
  bool is_sphere = false;
};

/// The normal of a target as a receiver.
glm::dvec3 receiver_normal(const SkyTarget& target, const SunHoursOptions& options);

/// Normal of a receiver that is tilted from the horizontal towards an azimuth; degrees, tilt in [0, 90].
glm::dvec3 tilted_normal(double tilt, double azimuth);

/// Radiation of every target, period by period.
///
/// Bins: light counts if nothing blocks a line towards the middle of its bin, and if it comes from the
/// front of the receiver and of the target's surface, also for a horizontal receiver. The sun is a
/// point, in front of a surface or behind it: call find_open_sides() first, since targets without
/// is_front_open count by their front.
///
/// Fans: light above the horizon of each azimuth (geo::TerrainSurface::horizon_slope) counts. Two things
/// differ from lines of sight: ground below the surface is solid also at the edges of holes and of the
/// raster, and slopes at the target count up to a micrometre from it, not a millimetre.
///
/// Reflected light is that of an even ground below an open sky: albedo times the global energy of the open
/// horizontal times (1 - z) / 2, with z that of the receiver's normal; things around it neither shade nor
/// brighten it. Source: Liu and Jordan, The Long-Term Average Performance of Flat-Plate Solar-Energy
/// Collectors, 1963; as in r.sun.
///
/// With a bounce reflected light is that of a BouncedLight of these targets instead.
///
/// Results do not depend on threads or instruction set. Requires targets times light.periods answers, target
/// by target. Errors: fans without has_horizons(); albedo or bounces out of range. Cost: a line per target
/// and bin, or a horizon (1 to 3 microseconds) per target and fan, in parallel; targets in the order of the
/// octree are fast.
void sun_hours(const Occluders& occluders, std::span<const SkyTarget> targets, const SunLight& light,
               const SunHoursOptions& options, std::span<Radiation> answers);

}  // namespace alidade::visibility
