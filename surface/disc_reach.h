// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/huge_memory.h"
#include "surface/surface_cloud.h"

// How far what a ray meets of a point lies from it along an axis. Most sheets are much flatter than spheres
// around their points: boxes of nodes that are widened by no more are met by far fewer of the rays that leave
// the ground or pass above it.
//
// With the radius r, the normal n and the height h of the point above its sheet, a disc reaches r sqrt(1 -
// n_a^2) + |h n_a| along axis a, and a lone sphere its radius. Reaches are stored, in metres, for radii of
// k_disc_spacings and lone_factors of k_reach_of_lone; disc_reach_factor() makes them those of a query.

namespace alidade {

constexpr double k_reach_of_lone = 0.28;  ///< spacings; no lone sphere of visibility or of pictures is wider

/// No reach of a query is greater than this times the stored one.
inline double disc_reach_factor(const SurfaceQuery& query) {
  const double lone_factor = std::min(query.discs->lone_factor, query.spacing_factor);
  return std::max({1.0, query.spacing_factor / k_disc_spacings, lone_factor / k_reach_of_lone});
}

/// SurfaceView::slot_reaches. octree: what the view has its tree from. Requires stored surfaces. Cost: some
/// nanoseconds of one thread per point, in parallel; 96 B per node.
HugeArray<std::uint16_t> slot_reaches(const Octree& octree, const SurfaceView& view);

}  // namespace alidade
