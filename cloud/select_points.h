// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "base/bounds.h"
#include "base/huge_memory.h"
#include "base/progress.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// A polygon in the plane, in world units. The last corner of a ring is joined to its first. Positions inside
/// an odd number of rings are inside, so that rings inside others are holes, whatever their orientation.
struct PlanePolygon {
  std::vector<std::vector<glm::dvec2>> rings;
};

// Points on the border are kept. As positions and limits are rounded, a point counts as on the border up to a
// thousandth of a lattice step outside, or up to a few roundings of the lattice's offset if these are larger.

/// Keeps the points inside a box and on its faces; sides may be infinite. Order is kept. `progress` is in
/// points. Memory: 1 B per point. Cost: linear. The result does not depend on the number of threads.
void crop(PointCloud& cloud, const Bounds& box, const Progress& progress = {});

/// Keeps the points above, below and in at least one of the polygons, or on a border. Requires finite
/// corners. A ring of one or two corners is a border without inside. Memory: 1 B per point and about 100 B
/// per corner. Cost: for each point, the edges of its strip from west to east.
void crop(PointCloud& cloud, std::span<const PlanePolygon> polygons, const Progress& progress = {});

/// Thins a cloud to one point per cube of the grid with this `edge`, world units, that has a corner at the
/// origin of the coordinates: clouds that are thinned separately match. A cube includes its lower faces, and
/// points up to a millionth of an edge below them; the upper faces belong to its neighbours.
///
/// The point that is kept is the nearest to the mean of the cube's points, the first of several. It keeps its
/// position and attributes, except for colour, near infrared and intensity, which become the rounded means of
/// the cube's points. Points keep their order. The result does not depend on the number of threads, and on
/// the order of points only if several are equally near.
///
/// `progress` is in points. Memory: 17 B per point. Cost: that of sorting.
/// Errors: an edge that is not a positive number; more than 2^32 - 1 cubes along an axis; more than 2^32 - 1
/// points.
void thin(PointCloud& cloud, double edge, const Progress& progress = {});

/// The columns that thinning reads and averages.
struct ThinnedColumns {
  Lattice lattice;
  std::span<const LatticePosition> positions;
  std::span<Color16> colors;
  std::span<std::uint16_t> near_infrared, intensities;
};

/// The marks of the rows that thin() keeps, whose values become the means. Memory: that of thin(), in
/// `scratch`. Errors: as thin(); those of scratch files.
HugeVector<std::uint8_t> mark_thinned(const ThinnedColumns& cloud, double edge, const ScratchFolder& scratch,
                                      const Progress& progress = {});

}  // namespace alidade
