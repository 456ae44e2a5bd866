// SPDX-License-Identifier: MIT
#include "visibility/raster/ground.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"
#include "visibility/raster/fill_gaps.h"
#include "visibility/raster/ground_samples.h"

namespace alidade {
namespace {

/// Cells within so many cells of one that is set, along rows or columns.
void widen(std::vector<std::uint8_t>& set, std::size_t count, std::size_t stride, std::size_t lines,
           std::size_t line_stride, int cells) {
  std::vector<std::uint8_t> line(count);
  for (std::size_t k = 0; k < lines; ++k) {
    const std::size_t first = k * line_stride;
    std::int64_t reached = -1;
    for (std::size_t i = 0; i < count; ++i) {
      if (set[first + i * stride]) reached = static_cast<std::int64_t>(i) + cells;
      line[i] = static_cast<std::int64_t>(i) <= reached;
    }
    reached = static_cast<std::int64_t>(count);
    for (std::size_t i = count; i-- > 0;) {
      if (set[first + i * stride]) reached = static_cast<std::int64_t>(i) - cells;
      line[i] = line[i] || static_cast<std::int64_t>(i) >= reached;
    }
    for (std::size_t i = 0; i < count; ++i) set[first + i * stride] = line[i];
  }
}

void widen(std::vector<std::uint8_t>& set, const RasterGrid& grid, double reach) {
  const double most = static_cast<double>(std::max(grid.columns, grid.rows));
  const int cells = static_cast<int>(std::min(std::ceil(reach / grid.cell_size), most));
  const auto columns = static_cast<std::size_t>(grid.columns), rows = static_cast<std::size_t>(grid.rows);
  widen(set, columns, 1, rows, columns, cells);
  widen(set, rows, columns, columns, 1, cells);
}

GroundSource chosen_source(GroundSource asked, bool is_classified) {
  if (asked == GroundSource::classified && !is_classified) {
    throw Error({.problem = "the ground cannot be made of class 2",
                 .expected = "points of class 2",
                 .found = "none in the cloud"});
  }
  if (asked != GroundSource::automatic) return asked;
  return is_classified ? GroundSource::classified : GroundSource::lowest;
}

/// Mean distance of `count` points over the bounds.
double mean_distance(const Bounds& bounds, std::uint64_t count) {
  const glm::dvec3 size = bounds.size();
  const double longest = std::max(size.x, size.y);
  if (longest == 0.0) return 1.0;
  // A line of points has no area: at least as wide as its points are apart.
  const double width = std::max(std::min(size.x, size.y), longest / static_cast<double>(count));
  return std::sqrt(longest * width / static_cast<double>(count));
}

}  // namespace

std::optional<double> Ground::at(const glm::dvec2& place) const {
  const RasterGrid& grid = heights_.grid;
  const glm::dvec2 corner = grid.south_east();
  const bool near = place.x >= grid.north_west.x - reach_ && place.x <= corner.x + reach_ &&
                    place.y >= corner.y - reach_ && place.y <= grid.north_west.y + reach_;
  if (!near) return std::nullopt;
  const double x = std::clamp((place.x - grid.north_west.x) / grid.cell_size - 0.5, 0.0, grid.columns - 1.0),
               y = std::clamp((grid.north_west.y - place.y) / grid.cell_size - 0.5, 0.0, grid.rows - 1.0);
  const int column = std::min(static_cast<int>(x), std::max(grid.columns - 2, 0)),
            row = std::min(static_cast<int>(y), std::max(grid.rows - 2, 0));
  const double east = x - column, south = y - row;
  double sum = 0.0, weights = 0.0;
  const auto take = [&](int i, int j, double weight) {
    if (weight == 0.0) return;
    const double height = heights_.at(i, j);
    if (std::isnan(height)) return;
    sum += weight * height;
    weights += weight;
  };
  take(column, row, (1.0 - east) * (1.0 - south));
  take(std::min(column + 1, grid.columns - 1), row, east * (1.0 - south));
  take(column, std::min(row + 1, grid.rows - 1), (1.0 - east) * south);
  take(std::min(column + 1, grid.columns - 1), std::min(row + 1, grid.rows - 1), east * south);
  if (weights == 0.0) return std::nullopt;
  return sum / weights;
}

Ground make_ground(const Octree& octree, std::span<const std::uint8_t> classifications,
                   const GroundOptions& options) {
  constexpr std::uint64_t k_bytes_per_cell = 50;
  constexpr double k_lowest_distances = 4.0;
  if (octree.size() == 0) throw Error({.problem = "a cloud without points has no ground"});
  if (!(options.reach >= 0.0) || !std::isfinite(options.reach))
    throw Error({.problem = "the ground reaches by a length of at least 0",
                 .found = fmt::format("{}", options.reach)});
  const GroundSource source = chosen_source(
      options.source, std::ranges::find(classifications, k_ground_class) != classifications.end());
  const bool by_class = source == GroundSource::classified;
  const auto count = by_class
                         ? static_cast<std::uint64_t>(std::ranges::count_if(classifications, is_on_ground))
                         : octree.size();
  const double distance = mean_distance(octree.bounds(), count);
  const RasterGrid grid = grid_over(
      octree.bounds(), options.cell_size.value_or(by_class ? distance : k_lowest_distances * distance));
  check_memory(k_bytes_per_cell * grid.size(), "the heights of the ground");

  GroundSamples samples = by_class ? mean_of_class(octree, classifications, grid, options.progress)
                                   : lowest_points(octree, grid, options.progress);
  Raster<double> heights = heights_in_middles(samples.samples);
  samples.samples = {};
  const auto measured = static_cast<std::uint64_t>(
      std::ranges::count_if(heights.values, [](double height) { return !std::isnan(height); }));
  fill_gaps(heights);
  widen(samples.covered, grid, options.reach);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (!samples.covered[i]) heights.values[i] = std::numeric_limits<double>::quiet_NaN();
  }
  return Ground(std::move(heights), options.reach, source, measured);
}

}  // namespace alidade
