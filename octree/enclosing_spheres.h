// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "octree/octree.h"
#include "octree/query.h"

namespace alidade {

/// A point with a radius of its own (RayQuery::spacing_factor).
struct PointSphere {
  glm::dvec3 center{0.0};   ///< the point, world coordinates
  double radius = 0.0;      ///< metres
  std::uint32_t index = 0;  ///< storage index of the point
};

/// Appends the spheres that hold a position, their surfaces included: distance <= radius, for the radii that
/// the query gives the points. In the order of the storage indices. Requires a checked query with a
/// spacing_factor above 0 and a finite radius, an octree that has spacings, and a finite position. Cost: some
/// hundred nanoseconds.
void find_enclosing(const Octree& octree, const glm::dvec3& position, const RayQuery& query,
                    std::vector<PointSphere>& spheres);

}  // namespace alidade
