// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "base/progress.h"
#include "octree/octree.h"
#include "octree/query.h"

// How far the points of a cloud stand from each other, point by point: what RayQuery::spacing_factor makes
// radii of.
//
//   const Octree octree = with_spacings(build(cloud), 8);
//   const auto hit = closest(octree, ray, {.radius = 0.5, .spacing_factor = 1.0});
//
// The spacing of a point is the distance to its n-th nearest neighbour: of the points that stand at another
// place, nearest first, the n-th; infinite if there are fewer. It is rounded up to eight significant bits (by
// at most 0.8 %), and that number is what all queries take as the spacing.

namespace alidade {

constexpr int k_most_spacing_neighbours = 64;

/// The same octree with the spacing of every point. An octree that has them for this n is returned as it is.
/// `progress` is in points. Cost: 1 to 2 microseconds of one thread per point (n = 8), in parallel; 2 B per
/// point and 16 B per node. Errors: n below 1 or above k_most_spacing_neighbours.
Octree with_spacings(const Octree& octree, int neighbours, const Progress& progress = {});

/// The 16 bits that stand for a spacing, rounded up; see spacing_of(). Requires: not negative, not NaN.
std::uint16_t spacing_bits(double metres);

/// The radius that a point had when a query with a spacing_factor found it: the same bits whatever the ray,
/// and those of the query's own unless a point's radius and the query's differ by less than 1e-8 of it, where
/// it may be the other. Requires |t| below 10^6 radii.
double sphere_radius(const RayQuery& query, const Hit& hit);

/// The spacings by point id, metres. Requires spacings. Cost: linear.
std::vector<double> spacings_in_order(const TreeView& tree);

}  // namespace alidade
