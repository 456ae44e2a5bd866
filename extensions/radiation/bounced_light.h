// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "extensions/radiation/radiation.h"

// Light that reaches a receiver by one reflection at surfaces that the sun and the sky light.
//
//   BouncedLight bounced(occluders, light, options, 0.0);
//   radiation(occluders, targets, light, options, answers);  // options.bounces = 0
//   bounced.add(targets, answers);

namespace alidade::visibility {

/// Sums the light that the surroundings of targets reflect, and keeps their irradiances for further targets.
///
/// A line goes into each of the 145 patches of the sky (line_into_patch()) and into their mirror images below
/// the horizon, as far as they are in front of the receiver and its surface. What a line meets first reflects
/// evenly in all directions: albedo / pi times its irradiance by sun and sky, times the integral of the
/// cosine over the patch. The integrals of each half are scaled so that their sum is exact, (1 + z) / 2 and
/// (1 - z) / 2 with z of the receiver's normal: within an even enclosure the light is exact, and never more
/// than albedo times the largest irradiance around.
/// - A point of a surface has the irradiance of the side that the line comes from, by lines of its own.
/// - A point without a surface reflects as a small sphere: its irradiance is that of a sphere on average, a
///   quarter of the light from all directions.
/// - Meshes and terrain, and directions below the horizon in which nothing blocks, reflect as open level
///   ground does: without obstructions this is radiation()' own reflected light.
/// Light that is reflected more than once is left out.
///
/// Source: radiosity with one iteration, Goral et al., Modeling the Interaction of Light Between Diffuse
/// Surfaces, 1984; patches as in Robinson and Stone 2004 (sky_patches.h).
///
/// In front of a wall of any size and direction the error is 0.01 of albedo times its irradiance (standard
/// deviation; at most 0.04) for a level receiver, 0.016 (at most 0.07) for one that faces it.
class BouncedLight {
 public:
  /// `options` are those of radiation(); `bounces` does not apply. `cell`: of surface points in a cube of
  /// this width with nearly equal normals, the one with the smallest id represents all; 0: every point is
  /// computed. The references must outlive the object. Cost: with a `cell` 0.2 microseconds per point.
  /// Memory: 8 B per point, or 4 B and 40 B per cube. Errors: cell negative or not finite.
  BouncedLight(const Occluders& occluders, const EnergyLight& light, const RadiationOptions& options,
               double cell);

  /// Replaces the reflected light in the answers of radiation(), targets times light.periods of them. The
  /// result does not depend on earlier calls. Cost: 145 lines per target that find blockers, and the lines
  /// of radiation() for every side that is met for the first time. Memory: 16 B per side and period that
  /// was met, 2 kB per target.
  void add(std::span<const SkyTarget> targets, std::span<Radiation> answers);

  /// radiation() of points of the cloud, without bounces, on their own surfaces. Each side is computed once,
  /// also if add() meets it before or after. Requires: the targets are those of target_on_point(), with an
  /// open front; cell = 0 and no RadiationOptions::normal; SkyReceiver::surface.
  void answer_points(std::span<const SkyTarget> targets, std::span<const std::uint64_t> point_ids,
                     std::span<Radiation> answers);

 private:
  struct Met;
  struct PendingSide {
    std::uint32_t slot;
    SkyTarget target;
  };
  struct Group {
    std::uint64_t point_id;
    glm::dvec3 position;
  };

  void group_points(double cell);
  std::uint32_t slot_of(const Blocker& blocker, const glm::dvec3& direction);
  std::uint32_t new_slot();
  void compute_pending();

  const Occluders& occluders_;
  const EnergyLight& light_;
  RadiationOptions options_;
  std::size_t periods_;
  std::vector<Group> groups_;            ///< empty: every point is computed
  std::vector<std::uint32_t> group_of_;  ///< by point id
  std::vector<std::uint32_t> slots_;     ///< of the two sides of points or groups; k_no_slot: not met
  std::vector<Radiation> energies_;      ///< of slots, period by period
  std::vector<PendingSide> pending_;     ///< slots without energies
};

}  // namespace alidade::visibility
