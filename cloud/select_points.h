// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "base/bounds.h"
#include "base/progress.h"
#include "cloud/point_cloud.h"

namespace alidade {

class ScratchCloud;

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

/// Thins a cloud to one point per cube of the grid with this `edge`, world units, one of whose corners is the
/// origin of the coordinates: clouds thinned apart fit together. A cube's lower faces are its own, and what
/// lies a millionth of an edge below them; the upper faces are its neighbours'.
///
/// The point that stays is a real one, the nearest to the mean of the cube's points, the first of equals. It
/// keeps its position and attributes, but for colour, near infrared and intensity, which become the means
/// over the cube's points, rounded. Points that stay keep their order. The result does not depend on the
/// number of threads; on the order of points only where several are equally near, and in that of the result.
///
/// `progress` is in points. Memory: 17 B per point, of a ScratchCloud on the disk. Cost: that of
/// sorting. Errors: an edge that is not a positive number; more than 2^32 - 1 cubes along an axis; more than 2^32 - 1 points.
void thin(PointCloud& cloud, double edge, const Progress& progress = {});
void thin(ScratchCloud& cloud, double edge, const Progress& progress = {});

}  // namespace alidade
