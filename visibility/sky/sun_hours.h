// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "geo/terrain_surface.h"
#include "visibility/sky/sky_view.h"
#include "visibility/sky/sun_light.h"

namespace alidade::visibility {

struct SunHoursOptions {
  SkyReceiver receiver = SkyReceiver::surface;
  double max_distance = std::numeric_limits<double>::infinity();  ///< nothing farther blocks; metres
  /// Normal of every receiver, of length 1, with z >= 0, instead of that of `receiver`.
  std::optional<glm::dvec3> normal{};
};

/// The normal of a target as a receiver.
glm::dvec3 receiver_normal(const SkyTarget& target, const SunHoursOptions& options);

/// Normal of a receiver that is tilted from the horizontal towards an azimuth; degrees, tilt in [0, 90].
glm::dvec3 tilted_normal(double tilt, double azimuth);

/// Hours of direct sun of every target, period by period.
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
/// Results do not depend on threads or instruction set. Requires targets times light.periods answers, target
/// by target. Errors: fans without has_horizons(). Cost: a line per target and bin, or a horizon (1 to 3
/// microseconds) per target and fan, in parallel; targets in the order of the octree are fast.
void sun_hours(const Occluders& occluders, std::span<const SkyTarget> targets, const LightOf<SunHours>& light,
               const SunHoursOptions& options, std::span<float> answers);

// For other sums.

/// Which of the targets get the light from a direction.
class LitTargets {
 public:
  /// The references must outlive the object.
  LitTargets(const Occluders& occluders, std::span<const SkyTarget> targets, const SunHoursOptions& options)
      : occluders_(occluders), targets_(targets), options_(options) {}

  /// Their indices, ascending, until the next call.
  std::span<const std::uint32_t> from(const glm::dvec3& direction);

 private:
  const Occluders& occluders_;
  std::span<const SkyTarget> targets_;
  const SunHoursOptions& options_;
  std::vector<std::uint32_t> lit_;
  std::vector<SightLine> lines_;
  std::vector<std::uint8_t> is_blocked_;
};

/// Errors: as sun_hours().
void check_fans(bool has_fans, const Occluders& occluders, const SunHoursOptions& options);

/// Calls take(share, count) for every share of fans: a target with this normal gets the light of the first
/// `count` slopes.
template <class Sums, class Take>
void for_fan_shares(const geo::TerrainSurface& terrain, const SkyTarget& target, const glm::dvec3& normal,
                    const std::vector<FanOf<Sums>>& fans, const Take& take) {
  for (const FanOf<Sums>& fan : fans) {
    const double facing = facing_slope(normal, fan.direction);
    if (std::isinf(facing)) continue;
    const double slope = terrain.horizon_slope(target.front.position, fan.direction, facing);
    for (const auto& share : fan.shares) {
      const auto end = std::ranges::lower_bound(share.slopes, slope, std::greater<>{});
      take(share, static_cast<std::size_t>(end - share.slopes.begin()));
    }
  }
}

}  // namespace alidade::visibility
