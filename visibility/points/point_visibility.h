// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/progress.h"
#include "visibility/observers.h"
#include "visibility/sight_line.h"

// Which points of a cloud which observers see.
//
//   const Occluders occluders(octree, {});
//   const PointVisibility seen = point_visibility(occluders, observers, {.with_blockers = true});
//   if (seen.counts[id] == 0) use(seen.blockers[0][id]);

namespace alidade {
class PartCheckpoint;
}

namespace alidade::visibility {

// Ids of clouds are smaller (octree/build.h).
constexpr std::uint32_t k_no_blocker = 0xFFFFFFFF;
constexpr std::uint32_t k_blocked_by_mesh = 0xFFFFFFFE;
constexpr int k_most_sub_rays = 255;
constexpr std::size_t k_most_mask_observers = 64;

struct PointVisibilityOptions {
  /// Lines to each point for PointVisibility::fractions, 1 to k_most_sub_rays. 1: no fractions.
  int sub_rays = 1;
  /// Whether to report blockers: lines are then followed to the first crossing, which takes longer.
  bool with_blockers = false;
  /// Limits the view of an observer further, for example to the frame of a photo; empty: no further limit.
  /// Called from many threads at once, for positions in the field of view and within max_distance. Must
  /// return the same answer for the same position.
  std::function<bool(std::size_t observer, const glm::dvec3& position)> in_view{};
  /// Called for one observer after another with what it sees: 1 or 0 by point id. May throw.
  std::function<void(std::size_t observer, std::span<const std::uint8_t> seen)> each_observer{};
  /// Finished parts, which are not computed again; null: nothing is kept. A part is what one
  /// observer sees of some 131072 points, divided by sub_rays, but of 8192 at least; it takes 1 bit
  /// per point, 1 B more with sub_rays, 4 B with blockers.
  PartCheckpoint* parts = nullptr;
  Progress progress{};  ///< in sight lines
};

/// Checks options and memory before a run. Errors: options out of range; not enough memory; the message
/// has the amount: 5 B per point, 8 B for the masks, 4 B for fractions, 4 B per observer for blockers,
/// and 12 B for writing them.
void check_point_visibility(std::uint64_t points, std::size_t observers,
                            const PointVisibilityOptions& options);

/// What observers see of the points of a cloud. All columns are by point id.
struct PointVisibility {
  /// Number of observers that see the point: it is in the field of view and not beyond max_distance, and
  /// nothing blocks the line from the eye to it (sight_line.h: the point's own surface does not).
  std::vector<std::uint32_t> counts;
  /// The observers that see the point: bit i for observer i. Empty for a single observer, and for more
  /// than k_most_mask_observers.
  std::vector<std::uint64_t> masks;
  /// Share of the lines to the disc around the point that nothing blocks; of several observers that of the
  /// one who sees most of it. The radius of the disc is a third of the point's spacing, since a circle with
  /// the spacing as radius holds nine points. It lies in the point's surface, or faces the eye if there is
  /// none. The lines end on a spiral that starts at the point and covers the disc evenly (Vogel, A better way
  /// to construct the sunflower head, 1979). Empty with one line.
  std::vector<float> fractions;
  /// By observer: the first point that blocks the line to the point itself; k_blocked_by_mesh if the mesh or
  /// terrain blocks it, k_no_blocker if nothing does or the point is out of view. Empty unless requested.
  std::vector<std::vector<std::uint32_t>> blockers;
};

/// Finds which points each observer sees. The same answer on any number of threads and any instruction
/// set. Observers on or a little above a surface are not blocked by it. Cost: sight_line.h's per line; lines
/// of one observer go to points in the octree's order. Memory: 5 B per point, 8 B for masks, 4 B for
/// fractions, and 4 B for the blockers of each observer. Errors: those of check_point_visibility(); of
/// `parts`: those of run_parts().
PointVisibility point_visibility(const Occluders& occluders, std::span<const Observer> observers,
                                 const PointVisibilityOptions& options);

}  // namespace alidade::visibility
