// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "base/checkpoint.h"
#include "base/progress.h"
#include "geo/raster.h"
#include "visibility/objects.h"
#include "visibility/observers.h"
#include "visibility/raster/curved_sight.h"
#include "visibility/raster/ground.h"

// What observers see of the ground, or of things so high above it, as a map. Lines of sight go through the
// points themselves: below crowns, bridges and balconies.
//
//   const Viewshed seen = viewshed(occluders, ground, observers, grid_over(octree.bounds(), 1.0), {});
//   if (seen.values.at(column, row) > 0.0f) ...

namespace alidade::visibility {

enum class ViewshedMode {
  visible,   ///< 1 where any observer sees the middle of the cell, otherwise 0
  count,     ///< how many observers see it
  height,    ///< from which height above the ground on something there is seen by any observer
  fraction,  ///< share of the lines of sight that are free, over all observers and positions of the cell
  size,      ///< of objects: how much of them is seen, as a length or area
  angle,     ///< of objects: solid angle of what is seen of them, in steradians
};

struct ViewshedOptions {
  ViewshedMode mode = ViewshedMode::visible;
  /// Of what is examined, above the ground; >= 0. In the unit of the cloud. Of `height`: the lowest looked
  /// at.
  double target_height = 0.0;
  SightCurve curve{};  ///< straight unless given
  /// What the observers are samples of, one each; empty: they are themselves who looks. Then cells are looked from,
  /// at the target height, and the map shows what is seen of the objects there.
  std::span<const ObjectPiece> pieces{};
  /// For `fraction`: positions_across x positions_across positions in every cell, in [1,
  /// k_most_positions_across].
  int positions_across = 3;
  /// Of `height`: nothing higher is tried, and this represents "not even there". In the unit of the cloud.
  double highest = 200.0;
  Progress progress{};              ///< in pairs of observer and position
  PartCheckpoint* parts = nullptr;  ///< where blocks of cells are kept that are finished; null: nowhere
};

/// Values of cells that no observer looks at: all out of reach or outside of their fields of view.
constexpr float k_out_of_range = -1.0f;
/// Values of cells where the cloud has no ground. Told by std::isnan.
constexpr float k_no_ground = std::numeric_limits<float>::quiet_NaN();

struct Viewshed {
  geo::Raster<float> values;
  std::uint64_t line_count = 0;  ///< sight lines that were followed, those of parts found finished left out
};

/// The map of what is seen. An observer looks at a position within its max_distance, along the line of sight,
/// and its field of view; both ends of a line lie on or above the surface of the cloud, which does not hide
/// them (visibility/sight_line.h). The same bits on any number of threads and instruction set.
///
/// `height`: from the target height up, lines are tried until one is free, each raised by the radius of the
/// point that blocked the one before, as it projects on the cell (at least 0.01), or by that of the widest
/// sphere if the mesh or terrain blocked it; over a terrain alone `highest` is tried at once. Then the height
/// is halved in to 0.01. So it is the lowest at which there is sight, also below a bridge or a crown, but for
/// openings lower than the points' own distances, and for holes of the terrain. Of several observers the lowest counts.
/// Only heights between the target height and `highest` that lie in an observer's field of view and within its distance
/// are tried: a cell whose ground lies below the view has the height at which the view begins, if that is seen, and
/// `highest` if nothing in the view is. Out of range are cells with no such height.
///
/// Of objects (visibility/objects.h) `visible` is 1 where any sample is seen, `count` the number of objects of
/// which one is, `fraction` the share of free lines weighted by the size of the pieces. Pieces that turn their
/// back to a cell or are out of reach do not count; where all do so, the cell is out of range.
///
/// Cost: a sight line per pair, 0.5 to 2 microseconds of two cores; `height` takes several to some hundred
/// where much is hidden. Memory: 4 B per cell and some 100 MB, of `height` 4 B per point as well;
/// check_map_memory() of one band. Errors: no observer; positions_across, target height or highest out of
/// range; not as many pieces as observers, `height` of objects, `size` and `angle` of none, `angle` of lines; not
/// enough memory; those of `parts`.
Viewshed viewshed(const Occluders& occluders, const Ground& ground, std::span<const Observer> observers,
                  const geo::RasterGrid& grid, const ViewshedOptions& options);

}  // namespace alidade::visibility
