// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bounds.h"
#include "visibility/observers.h"
#include "visibility/raster/ground.h"
#include "visibility/sight_line.h"

// The targets of a map: positions above the ground of its cells.

namespace alidade::visibility {

constexpr int k_most_positions_across = 100;

/// A position on the ground as an end of sight lines. Heights of the ground come from several points, so that
/// a position may lie a little inside the sheet of the points around it, and be hidden by it. So it is raised
/// to the lower face of that sheet (one standard deviation) if it is lower, and lifted by the sheet's
/// thickness, as end_on_point() does. The sheet is that of the nearest of 8 points whose sheets are rather
/// flat and pass within the typical radius of the position; the sheets of all such points are the end's own
/// surface. If there are none within the largest radius, the position is the end.
SightEnd end_on_ground(const Occluders& occluders, const glm::dvec3& position);

/// An end at this height above another, with the same own surface.
inline SightEnd raised(SightEnd end, double height) {
  end.position.z += height;
  return end;
}

/// A position on the ground of a map.
struct MapTarget {
  std::size_t cell = 0;  ///< number of its cell in the block
  SightEnd foot;         ///< on the ground
};

/// A square part of a map.
struct MapBlock {
  std::vector<std::size_t> cells;  ///< their numbers in the map, neighbours near each other
  std::vector<MapTarget> targets;  ///< the positions on scanned ground, in the order of the cells
};

/// The targets of a map, block by block, so that maps of any size take little memory:
/// 150 B per position of a block.
class MapTargets {
 public:
  /// Every cell has `positions_across` x `positions_across` positions, evenly spread, in
  /// [1, k_most_positions_across]; a single one is the centre. `most_positions`: limit per block; a
  /// block has at least one cell and at most 2^16, so the blocks do not depend on the machine. The
  /// references must outlive this.
  MapTargets(const Occluders& occluders, const Ground& ground, const geo::RasterGrid& grid,
             int positions_across, std::size_t most_positions);

  std::size_t block_count() const;
  /// MapBlock::cells of a block.
  std::vector<std::size_t> cells(std::size_t number) const;
  /// A block with its targets; in parallel.
  MapBlock block(std::size_t number) const;

 private:
  const Occluders& occluders_;
  const Ground& ground_;
  geo::RasterGrid grid_;
  int positions_across_;
  int block_levels_;  ///< a block is 2^this cells wide
};

/// Heights above the ground, limits inclusive.
struct HeightRange {
  double low = 0.0, high = 0.0;
};

/// An observer prepared for many lines of sight.
class MapObserver {
 public:
  MapObserver(const Occluders& occluders, const Observer& observer);

  const SightEnd& eye() const { return eye_; }

  /// Whether a position is in its field of view and reach.
  bool looks_at(const glm::dvec3& position) const { return view_.reaches(position - eye_.position); }

  /// The heights in `tested` above `foot` that are between the lower and the upper limit of its field of view
  /// and not farther away than its max_distance. The lower end is that of `tested` if looks_at() is true for
  /// it. Empty: no height is in view. The same on every machine.
  std::optional<HeightRange> heights_in_view(const glm::dvec3& foot, const HeightRange& tested) const;

 private:
  SightEnd eye_;
  FieldOfView view_, azimuths_;
  double max_distance_;
  double lower_slope_, upper_slope_;  ///< rise per length of the ground at the limits of the view
};

/// The part of an area that is in reach of any observer, in x and y. `who`: the observers, for the
/// message. Errors: nothing of the area is in reach.
Bounds area_in_reach(const Bounds& area, std::span<const Observer> observers,
                     const std::string& who = "observer");

/// The default cell size of an area: 1, 2 or 5 times a power of ten, the smallest that gives
/// at most 1000 cells along the longer side and is not below `finest`.
double usual_resolution(const Bounds& area, double finest = 0.0);

}  // namespace alidade::visibility
