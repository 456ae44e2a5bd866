// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "base/progress.h"
#include "geo/raster.h"
#include "visibility/objects.h"
#include "visibility/observers.h"
#include "visibility/raster/curved_sight.h"
#include "visibility/raster/ground.h"

// What observers see of the ground, or of targets at a height above it, as a map. Lines of sight go through
// the points themselves: also below crowns, bridges and balconies.
//
//   const Viewshed seen = viewshed(occluders, ground, observers, grid_over(octree.bounds(), 1.0), {});
//   if (seen.values.at(column, row) > 0.0f) ...

namespace alidade {
class PartCheckpoint;
}

namespace alidade::visibility {

enum class ViewshedMode {
  visible,   ///< 1 where any observer sees the middle of the cell, otherwise 0
  count,     ///< number of observers that see it
  height,    ///< lowest height above the ground there that any observer sees
  fraction,  ///< share of the lines of sight that are free, over all observers and positions of the cell
  size,      ///< of objects: length or area of what is seen of them
  angle,     ///< of objects: solid angle of what is seen of them, in steradians
};

struct ViewshedOptions {
  ViewshedMode mode = ViewshedMode::visible;
  /// Height of the targets above the ground; >= 0. In the unit of the cloud. For `height`: the lowest that is
  /// tried.
  double target_height = 0.0;
  SightCurve curve{};  ///< straight unless given
  /// If the observers are samples of objects: the piece of each. Then the map shows what is seen of the
  /// objects from the target height above each cell. Empty: they are observers.
  std::span<const ObjectPiece> pieces{};
  /// For `fraction`: positions_across x positions_across positions in every cell, in
  /// [1, k_most_positions_across].
  int positions_across = 3;
  /// For `height`: the highest that is tried, > target_height, and the value if it is not seen, either. In
  /// the unit of the cloud.
  double highest = 200.0;
  Progress progress{};              ///< in pairs of observer and position
  PartCheckpoint* parts = nullptr;  ///< where finished blocks of cells are kept; null: nowhere
};

/// Values of cells that no observer looks at: all out of reach or outside of their fields of view.
constexpr float k_out_of_range = -1.0f;
/// Values of cells without ground that was scanned. To be tested with std::isnan().
constexpr float k_no_ground = std::numeric_limits<float>::quiet_NaN();

struct Viewshed {
  geo::Raster<float> values;
  std::uint64_t line_count = 0;  ///< sight lines followed, without those of parts that were finished before
};

/// The map of what is seen. An observer looks at a position within its max_distance, along the line of sight,
/// and its field of view; both ends of a line lie on or above the surface of the cloud, which does not hide
/// them (visibility/sight_line.h). The same bits on any number of threads and instruction set.
///
/// `height`: from the target height up, lines are tried until one is free, each raised by the radius of
/// the point that blocked the one before, as it projects on the cell (at least 0.01), or by the typical
/// radius if the mesh or terrain blocked it; over a terrain alone `highest` is tried at once. Then the
/// interval is halved down to 0.01. So it is the lowest height that is seen, also below a bridge or a
/// crown, except for openings lower than the spacing of the points, and for holes of the terrain. Of
/// several observers the lowest counts. Only heights between the target height and `highest` that are in
/// an observer's field of view and within its distance are tried: a cell whose ground is below the view
/// has the height at which the view begins, if that is seen, and `highest` if nothing in the view is seen.
/// Cells without such a height are out of range.
///
/// For objects (visibility/objects.h) `visible` is 1 where any sample is seen, `count` the number of objects
/// with such a sample, `fraction` the share of free lines weighted by the size of the pieces. Pieces that
/// face away from a cell or are out of reach do not count; cells where none counts are out of range.
///
/// Cost: a sight line per pair, 0.5 to 2 microseconds of two cores; for `height` several to some hundred if
/// much is hidden. Memory: 4 B per cell and some 100 MB, of `height` 4 B per point as well;
/// check_map_memory() of one band. Errors: no observer; positions_across, target height or highest out of
/// range; not as many pieces as observers, `height` of objects, `size` and `angle` of none, `angle` of lines;
/// not enough memory; those of `parts`.
Viewshed viewshed(const Occluders& occluders, const Ground& ground, std::span<const Observer> observers,
                  const geo::RasterGrid& grid, const ViewshedOptions& options);

}  // namespace alidade::visibility
