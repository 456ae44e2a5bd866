// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "base/progress.h"
#include "geo/raster.h"
#include "octree/octree.h"

// The first steps of make_ground() (visibility/raster/ground.h): what each cell shows of the ground by itself.

namespace alidade::visibility {

/// Class of ASPRS.
constexpr std::uint8_t k_ground_class = 2;

/// Whether points of a class lie on the ground: ground, water, road surface. Where ground was classified,
/// roads and water are mostly classes of their own, and would be holes in it.
constexpr bool is_on_ground(std::uint8_t point_class) {
  constexpr std::uint8_t k_water = 9, k_road = 11;
  return point_class == k_ground_class || point_class == k_water || point_class == k_road;
}

/// A height that was measured somewhere in a cell.
struct GroundSample {
  glm::vec2 offset{0.0f};  ///< of the position from the middle of the cell
  double height = 0.0;     ///< NaN if nothing was measured

  bool exists() const { return height == height; }
};

struct GroundSamples {
  geo::Raster<GroundSample> samples;
  std::vector<std::uint8_t> covered;  ///< cells with points of any class
};

/// Of every cell the mean of its points of classes on the ground.
GroundSamples mean_of_class(const Octree& octree, std::span<const std::uint8_t> classifications,
                            const geo::RasterGrid& grid, const Progress& progress);

/// Of every cell the lowest point that is not an outlier.
GroundSamples lowest_points(const Octree& octree, const geo::RasterGrid& grid, const Progress& progress);

/// Heights in the middles of cells; NaN where nothing was measured.
geo::Raster<double> heights_in_middles(const geo::Raster<GroundSample>& samples);

}  // namespace alidade::visibility
