// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "base/bounds.h"
#include "base/progress.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// A polygon in the plane, in world units. The last corner of a ring is joined to its first. Inside is what
/// lies inside an odd number of rings, so that rings inside others are holes whichever way they run.
struct PlanePolygon {
  std::vector<std::vector<glm::dvec2>> rings;
};

// Points on the border stay. As positions and limits are rounded, a point counts as on the border up to a
// thousandth of a lattice step outside, or up to a few roundings of the lattice's offset where these are
// larger.

/// Keeps the points inside a box and on its faces; sides may be infinite. Order is kept. `progress` is in
/// points. Memory: 1 B per point. Cost: linear. The result does not depend on the number of threads.
void crop(PointCloud& cloud, const Bounds& box, const Progress& progress = {});

/// Keeps the points above, below and in at least one of the polygons, or on a border. Corners are finite; a
/// ring of one or two corners is a border without inside. Memory: 1 B per point and about 100 B per corner.
/// Cost: for each point, the edges that pass it to the east and west, found by strips.
void crop(PointCloud& cloud, std::span<const PlanePolygon> polygons, const Progress& progress = {});

}  // namespace alidade
