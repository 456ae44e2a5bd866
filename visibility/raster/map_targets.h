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

// What is examined on a map: positions above the ground of its cells.

namespace alidade::visibility {

constexpr int k_most_positions_across = 100;

/// A position on the ground as an end of sight lines. Heights of the ground come from several points, so that
/// a position may lie a little in the sheet of the points around it, and hidden by it. So it is brought up to
/// the lower face of that sheet (one standard deviation) if it lies deeper, and lifted by the sheet's
/// thickness, as points are that are examined. The sheet is that of the nearest of 8 points whose sheets lie
/// rather flat and pass the position within the widest sphere; the sheets of all such points are the end's
/// own surface. Where there are none within the widest radius, the position as it is.
SightEnd end_on_ground(const Occluders& occluders, const glm::dvec3& position);

/// An end so far above another, with the same surface as its own.
inline SightEnd raised(SightEnd end, double height) {
  end.position.z += height;
  return end;
}

/// A position that is examined.
struct MapTarget {
  std::size_t cell = 0;  ///< number of its cell in the block
  SightEnd foot;         ///< on the ground
};

/// A square part of a map.
struct MapBlock {
  std::vector<std::size_t> cells;  ///< their numbers in the map, neighbours near each other
  std::vector<MapTarget> targets;  ///< the positions with ground that was scanned, in the order of the cells
};

/// The positions of a map, block by block, so that a map of any size and with any number of positions takes
/// little memory: 150 B per position of a block.
class MapTargets {
 public:
  /// `positions_across` x `positions_across` positions in every cell, evenly spread, in [1,
  /// k_most_positions_across]; 1 is the centre. `most_positions`: limit per block; a block has at least one
  /// cell and at most 2^16, so the blocks do not depend on the machine. The references must outlive this.
  MapTargets(const Occluders& occluders, const Ground& ground, const geo::RasterGrid& grid,
             int positions_across, std::size_t most_positions);

  std::size_t block_count() const;
  /// The cells of a block, as MapBlock has them.
  std::vector<std::size_t> cells(std::size_t number) const;
  /// A block with its positions; in parallel.
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

/// An observer ready for many lines of sight.
class MapObserver {
 public:
  MapObserver(const Occluders& occluders, const Observer& observer);

  const SightEnd& eye() const { return eye_; }

  /// Whether it looks at a position at all.
  bool looks_at(const glm::dvec3& position) const { return view_.reaches(position - eye_.position); }

  /// The heights in `asked` above a position that it looks at: those between the lower and the upper limit of
  /// its field of view there, not farther away than its distance. Its lower end is that of `asked` if the
  /// observer looks at that, by looks_at(). Empty: it looks at none. The same on every machine.
  std::optional<HeightRange> heights_in_view(const glm::dvec3& foot, const HeightRange& asked) const;

 private:
  SightEnd eye_;
  FieldOfView view_, azimuths_;
  double max_distance_;
  double lower_slope_, upper_slope_;  ///< rise per length of the ground at the limits of the view
};

/// The part of an area that is in reach of any observer, in x and y. Errors: none is; `who` they are.
Bounds area_in_reach(const Bounds& area, std::span<const Observer> observers,
                     const std::string& who = "observer");

/// A cell size for an area, where nobody chose one: 1, 2 or 5 times a power of ten, the smallest that gives
/// at most 1000 cells along the longer side and is not below `finest`.
double usual_resolution(const Bounds& area, double finest = 0.0);

}  // namespace alidade::visibility
