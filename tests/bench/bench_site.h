// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "octree/build.h"
#include "octree/query.h"

namespace alidade::bench {

/// Rays of one kind, in the order in which they are queried.
struct RaySet {
  std::string_view name;
  std::vector<Ray> rays;
};

inline constexpr std::array k_closest_sets{"P", "S", "S_shuffled"};
inline constexpr std::array k_occluded_sets{"P", "S", "S_shuffled", "A_sun", "A_vis"};

/// The campus at one size, with the rays that every benchmark casts:
/// - P: primary. Three cameras, 600 x 400 pixels each, in pixel order; two at eye height, one on a roof.
/// - S: one bounce from every hit of P, spread by the cosine around the sphere's normal, in pixel order.
/// - S_shuffled: the same in random order.
/// - A_sun: from every hit of P that faces the sun toward it, all parallel.
/// - A_vis: from 50 observers at eye height to random points within 30 m, up to shortly before the point.
struct BenchSite {
  PointCloud cloud;
  Octree octree;
  double radius = 0.0;  ///< 2.5 times the mean distance to the nearest neighbour
  std::array<RaySet, 5> ray_sets;

  const std::vector<Ray>& rays(std::string_view set) const;
  /// Rays that start on a sphere must not meet it again.
  RayQuery query() const { return {.radius = radius, .measure = Measure::entry, .entry_min = k_entry_min}; }
  static constexpr double k_entry_min = 1e-6;
};

/// Made at the first call for a size, then kept.
const BenchSite& bench_site(std::size_t point_count);

}  // namespace alidade::bench
