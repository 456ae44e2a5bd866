// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cloud/select_points.h"
#include "geo/raster.h"

namespace alidade::visibility {

/// The union of some cells of a map as polygons, one for each set of cells connected by their sides: its
/// outline first, counter-clockwise, then its holes, clockwise. Corners are corners of cells where the
/// outline turns. Rings do not cross themselves or others; they may touch others at corners, as OGC
/// 06-103r4 allows. Polygons are in the order of their first cells, row by row. marked: 0 or 1 by cell.
/// Cost: linear. Memory: 4 B per cell.
std::vector<PlanePolygon> outline(const geo::RasterGrid& grid, std::span<const std::uint8_t> marked);

/// Width of the cells of footprints of points: twice the median distance to the 8th neighbour, so that a cell
/// on a surface holds some ten points, rounded up to 1, 2 or 5 times a power of ten, or more, so that there
/// are no more than 2^20 cells. Requires a spacing above 0.
double footprint_cell(const Bounds& area, double median_spacing);

}  // namespace alidade::visibility
