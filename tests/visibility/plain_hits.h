// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <span>
#include <vector>

#include "octree/brute_force.h"
#include "surface/brute_force_surface.h"
#include "visibility/crossing.h"

namespace alidade::test {

/// The candidates of a line that a filter admits, by a look at every point, in their order. spacings: by id.
inline std::vector<Hit> plain_hits(const visibility::Occluders& occluders, const PointCloud& cloud,
                                   std::span<const double> spacings, const visibility::SightLine& line,
                                   const CandidateFilter& filter) {
  return visibility::with_query(occluders, [&](const auto&, auto query) {
    query.filter = filter;
    const Ray ray = visibility::ray_of(occluders, line);
    if constexpr (std::same_as<decltype(query), RayQuery>) {
      return brute_force::find(cloud, ray, query);
    } else {
      return brute_force::find(cloud, ray, query, spacings, occluders.octree().layers());
    }
  });
}

}  // namespace alidade::test
