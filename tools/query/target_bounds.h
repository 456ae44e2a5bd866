// SPDX-License-Identifier: MIT
#pragma once

#include "base/bounds.h"
#include "octree/query.h"

namespace alidade {

// Boxes around the points of a cloud that lies in the box `within` which can answer a target: of all points
// at most `radius` from it. A little larger than need be, so that rounding leaves no point out; empty if
// there are none. `radius` means nothing for cones, half-spaces and boxes.

Bounds target_bounds(const Ray& ray, double radius, const Bounds& within);
Bounds target_bounds(const Cone& cone, double radius, const Bounds& within);
Bounds target_bounds(const Path& path, double radius, const Bounds& within);
Bounds target_bounds(const HalfSpaces& region, double radius, const Bounds& within);
Bounds target_bounds(const Bounds& box, double radius, const Bounds& within);
Bounds target_bounds(const glm::dvec3& place, double radius, const Bounds& within);

}  // namespace alidade
