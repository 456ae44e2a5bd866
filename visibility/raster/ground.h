// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/progress.h"
#include "geo/raster.h"
#include "geo/terrain_surface.h"
#include "octree/octree.h"

// The ground below a cloud, as heights on a grid.
//
//   const Ground ground = make_ground(octree, columns.classifications, {});
//   if (std::optional<double> z = ground.at({x, y})) add_mast({x, y, *z});

namespace alidade::visibility {

enum class GroundSource {
  automatic,   ///< by class if the cloud has points of class 2, otherwise lowest points
  classified,  ///< points of the ASPRS classes 2, ground, 9, water, and 11, road surface
  lowest,      ///< the lowest point of each cell: a roof or a crown if no ground was scanned
  highest,     ///< the highest point of each cell: roofs and crowns, as in a digital surface model
  terrain,     ///< not of points: the heights of an elevation raster
};

struct GroundOptions {
  GroundSource source = GroundSource::automatic;
  /// Side of the grid's cells. Empty: for points of these classes their mean distance, for lowest points four
  /// times that of all points, so that most cells have one that reached the ground, for highest points twice.
  std::optional<double> cell_size{};
  /// Gaps are closed as far as this from the nearest cell with a point of any class; there is no ground
  /// farther away. In the unit of the cloud.
  double reach = 10.0;
  /// Ground farther than this from the nearest cell with a point of any class counts as not scanned
  /// (is_scanned()). Empty: three cells, at least 1, at most `reach`.
  std::optional<double> scanned_reach{};
  Progress progress{};  ///< in points
};

/// Heights of the ground, of points or of an elevation raster.
class Ground {
 public:
  /// `heights`: NaN without ground. `reach`: the ground extends so far beyond the grid, as at its
  /// edge. `scanned`: 1 for cells that were scanned; empty: those with a height.
  Ground(geo::Raster<double> heights, double reach, GroundSource source, std::uint64_t measured_cells,
         HugeVector<std::uint8_t> scanned = {})
      : heights_(std::move(heights)),
        reach_(reach),
        source_(source),
        measured_cells_(measured_cells),
        scanned_(std::move(scanned)) {}

  /// The ground of a terrain, which ends at the outer edges of its cells.
  explicit Ground(const geo::TerrainSurface& terrain);

  /// From now on at() is the higher of both grounds, or the only one, since nothing below a terrain is seen.
  /// heights() and the other functions remain those of this one.
  void raise_to(std::shared_ptr<const Ground> terrain) { terrain_ = std::move(terrain); }

  /// Bilinear between the middles of cells; constant beyond the outermost middles; beside a cell without
  /// height, from the others. Empty if there is no ground.
  std::optional<double> at(const glm::dvec2& position) const;

  /// Whether the ground here was scanned, or a raster has a height for the cell. Otherwise it is interpolated
  /// over a gap or extrapolated, and visibility there is unknown: maps have no value. Ground with points of
  /// any class above it counts as scanned, as below roofs and crowns.
  bool is_scanned(const glm::dvec2& position) const;

  const geo::Raster<double>& heights() const { return heights_; }
  /// Never `automatic`.
  GroundSource source() const { return source_; }
  /// Cells with a height of their own; that of the others is interpolated.
  std::uint64_t measured_cells() const { return measured_cells_; }

 private:
  std::optional<double> own_at(const glm::dvec2& position) const;

  geo::Raster<double> heights_;
  double reach_;
  GroundSource source_;
  std::uint64_t measured_cells_;
  HugeVector<std::uint8_t> scanned_{};  ///< by cell
  std::shared_ptr<const Ground> terrain_{};
};

/// Length of the straight line between two positions, in x and y, over ground that was not scanned, found in
/// even steps of half a cell, at most 10^6 of them.
double unscanned_length(const Ground& ground, const glm::dvec2& from, const glm::dvec2& to);

/// The ground under a cloud, over all its bounds. `classifications` by point id; empty if the cloud has
/// none. The height of a cell is the mean of its ground points, or its lowest or highest point, moved to the
/// middle of the cell along the slope of its neighbours, so that planes are exact. A lowest or highest point
/// that is farther below or above all others of its cell and of the cells around than 1 + the cell's side (a
/// wrong echo, a bird) is an outlier. Gaps are filled by a membrane (Laplace's equation). Cost: about 30 ns
/// per point and cell. Memory: 50 B per cell, checked beforehand; on the disk if the octree has scratch
/// files. Errors: an empty cloud; `classified` without points of class 2; `terrain`; those of grid_over();
/// reach negative or not finite.
Ground make_ground(const Octree& octree, std::span<const std::uint8_t> classifications,
                   const GroundOptions& options);

/// Replaces every NaN by the membrane through the values around it, flat towards the outer edge. If there
/// is no value, all remain NaN. Other values are unchanged. The same bits on any number of threads. Cost:
/// about 100 ns per cell. Memory: 14 B per cell, of the kind that the raster uses. Method: cascadic
/// multigrid, a pyramid of means: from its top down each level starts with the one above, smoothed by
/// Gauss-Seidel sweeps in red and black. Source: Bornemann and Deuflhard, The cascadic multigrid method
/// for elliptic problems, 1996.
void fill_gaps(geo::Raster<double>& raster);

}  // namespace alidade::visibility
