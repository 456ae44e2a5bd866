// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>

#include "octree/octree.h"
#include "octree/point_surface.h"

// Where the sheet of points that a point belongs to ends beside it: at the edge of a roof, or where the
// scanner's shadow begins. There a disc around the point would reach out into the air.

namespace alidade {

/// The nearest edge of the sheet of a point.
struct SheetEdge {
  glm::dvec3 direction{0.0};  ///< of length 1, in the plane of the sheet, towards the edge
  double distance =
      std::numeric_limits<double>::infinity();  ///< in spacings of the point; infinite if none is near
};

/// The edge of a point's sheet in 8 bits, 0 for none: that direction in which the sheet's points within 2.5
/// spacings reach least far, if they reach at least 1.5 spacings the other way; a fifth of a spacing is added
/// for the gap between the last point and the edge. Edges farther away than 0.85 spacings are not kept.
/// Sheets that end on both sides, such as lines of a scan far from each other, have no edge. position and
/// spacing: of the point, metres, the spacing finite and above 0; surface: as surface_of() tells it. The same
/// bits on every instruction set. Cost: 3 microseconds.
std::uint8_t fit_sheet_edge(const Octree& octree, const glm::dvec3& position, double spacing,
                            const PointSurface& surface);

/// The edge beside a point, whose direction is one of 32 and whose distance is good to a tenth of a spacing.
/// Requires surfaces; normal: that of surface_of().
SheetEdge edge_of(const TreeView& tree, std::uint64_t point_id, const glm::dvec3& normal);

}  // namespace alidade
