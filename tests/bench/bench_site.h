// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "octree/build.h"
#include "octree/query.h"

namespace alidade::bench {

/// The simulated courtyard at one size, with the rays every benchmark asks.
struct BenchSite {
  PointCloud cloud;
  Octree octree;
  double radius = 0.0;       ///< automatic_radius
  std::vector<Ray> primary;  ///< three cameras, 600 x 400 pixels each, in pixel order
  std::vector<Ray>
      secondary;  ///< one bounce from every primary hit, spread by the cosine around the sphere's normal
  std::vector<Ray> sun;  ///< from every primary hit to one sun
  RayQuery query() const { return {.radius = radius, .measure = Measure::entry, .entry_min = 1e-6}; }
};

/// Made at the first call for a size, then kept.
const BenchSite& bench_site(std::size_t point_count);

}  // namespace alidade::bench
