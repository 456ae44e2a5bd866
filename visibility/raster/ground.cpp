// SPDX-License-Identifier: MIT
#include "visibility/raster/ground.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/error.h"
#include "base/huge_memory.h"
#include "visibility/raster/ground_samples.h"

namespace alidade::visibility {
namespace {

struct Level {
  geo::Raster<double> heights;
  std::vector<std::uint8_t> known;

  int columns() const { return heights.grid.columns; }
  int rows() const { return heights.grid.rows; }
  double value(int column, int row) const {
    return heights.at(std::clamp(column, 0, columns() - 1), std::clamp(row, 0, rows() - 1));
  }
};

/// Half as many cells each way; a cell is known if one of its four is.
Level coarser(const Level& fine) {
  geo::RasterGrid grid = fine.heights.grid;
  grid.columns = (grid.columns + 1) / 2;
  grid.rows = (grid.rows + 1) / 2;
  grid.cell_size *= 2.0;
  Level level{geo::Raster<double>(grid, 0.0), std::vector<std::uint8_t>(grid.size(), 0)};
  tbb::parallel_for(0, grid.rows, [&](int row) {
    for (int column = 0; column < grid.columns; ++column) {
      double sum = 0.0;
      int count = 0;
      for (int y = 2 * row; y < std::min(2 * row + 2, fine.rows()); ++y) {
        for (int x = 2 * column; x < std::min(2 * column + 2, fine.columns()); ++x) {
          const std::size_t i = fine.heights.grid.index(x, y);
          if (!fine.known[i]) continue;
          sum += fine.heights.values[i];
          ++count;
        }
      }
      const std::size_t i = grid.index(column, row);
      level.known[i] = count > 0;
      if (count > 0) level.heights.values[i] = sum / count;
    }
  });
  return level;
}

/// Unknown cells from the level above: bilinear between the middles of its cells.
void start_from(const Level& coarse, Level& fine) {
  tbb::parallel_for(0, fine.rows(), [&](int row) {
    for (int column = 0; column < fine.columns(); ++column) {
      const std::size_t i = fine.heights.grid.index(column, row);
      if (fine.known[i]) continue;
      // The middle of a cell stands a quarter of the larger cell from that cell's middle.
      const int x = column / 2, y = row / 2;
      const int beside = column % 2 == 0 ? x - 1 : x + 1, above = row % 2 == 0 ? y - 1 : y + 1;
      fine.heights.values[i] = 0.5625 * coarse.value(x, y) + 0.1875 * coarse.value(beside, y) +
                               0.1875 * coarse.value(x, above) + 0.0625 * coarse.value(beside, above);
    }
  });
}

/// Every unknown cell of a colour becomes the mean of its four neighbours, which are of the other.
void sweep(Level& level, int color) {
  tbb::parallel_for(0, level.rows(), [&](int row) {
    for (int column = (row + color) % 2; column < level.columns(); column += 2) {
      const std::size_t i = level.heights.grid.index(column, row);
      if (level.known[i]) continue;
      // Beyond the edge everything is as on it: the cell itself does not count.
      double sum = 0.0;
      int count = 0;
      const auto take = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= level.columns() || y >= level.rows()) return;
        sum += level.heights.at(x, y);
        ++count;
      };
      take(column - 1, row);
      take(column + 1, row);
      take(column, row - 1);
      take(column, row + 1);
      if (count > 0) level.heights.values[i] = sum / count;
    }
  });
}

bool all_known(const Level& level) {
  return std::ranges::all_of(level.known, [](std::uint8_t known) { return known != 0; });
}

}  // namespace

void fill_gaps(geo::Raster<double>& raster) {
  constexpr int k_sweeps = 24;
  std::vector<Level> levels(1);
  levels[0].known.resize(raster.values.size());
  for (std::size_t i = 0; i < raster.values.size(); ++i) levels[0].known[i] = !std::isnan(raster.values[i]);
  if (std::ranges::none_of(levels[0].known, [](std::uint8_t known) { return known != 0; })) return;
  levels[0].heights = std::move(raster);
  while (!all_known(levels.back())) levels.push_back(coarser(levels.back()));
  for (std::size_t i = levels.size() - 1; i-- > 0;) {
    start_from(levels[i + 1], levels[i]);
    for (int k = 0; k < k_sweeps; ++k) {
      sweep(levels[i], 0);
      sweep(levels[i], 1);
    }
  }
  raster = std::move(levels[0].heights);
}

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

void widen(std::vector<std::uint8_t>& set, const geo::RasterGrid& grid, double reach) {
  const double most = static_cast<double>(std::max(grid.columns, grid.rows));
  const int cells = static_cast<int>(std::min(std::ceil(reach / grid.cell_size), most));
  const auto columns = static_cast<std::size_t>(grid.columns), rows = static_cast<std::size_t>(grid.rows);
  widen(set, columns, 1, rows, columns, cells);
  widen(set, rows, columns, columns, 1, cells);
}

GroundSource chosen_source(GroundSource asked, bool is_classified) {
  check_that(asked != GroundSource::classified || is_classified, "missing ground class", "points of class 2",
             "none in the cloud");
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

std::optional<double> Ground::at(const glm::dvec2& position) const {
  const geo::RasterGrid& grid = heights_.grid;
  const glm::dvec2 corner = grid.south_east();
  const bool near = position.x >= grid.north_west.x - reach_ && position.x <= corner.x + reach_ &&
                    position.y >= corner.y - reach_ && position.y <= grid.north_west.y + reach_;
  if (!near) return std::nullopt;
  const double x = std::clamp((position.x - grid.north_west.x) / grid.cell_size - 0.5, 0.0,
                              grid.columns - 1.0),
               y = std::clamp((grid.north_west.y - position.y) / grid.cell_size - 0.5, 0.0, grid.rows - 1.0);
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
  if (octree.size() == 0) throw Error({.problem = "the cloud has no points for the ground"});
  check_that(options.reach >= 0.0 && std::isfinite(options.reach),
             "the reach of the ground must be at least 0", {}, fmt::format("{}", options.reach));
  const GroundSource source = chosen_source(
      options.source, std::ranges::find(classifications, k_ground_class) != classifications.end());
  const bool by_class = source == GroundSource::classified;
  const auto count = by_class
                         ? static_cast<std::uint64_t>(std::ranges::count_if(classifications, is_on_ground))
                         : octree.size();
  const double distance = mean_distance(octree.bounds(), count);
  const geo::RasterGrid grid = geo::grid_over(
      octree.bounds(), options.cell_size.value_or(by_class ? distance : k_lowest_distances * distance));
  check_memory(k_bytes_per_cell * grid.size(), "the heights of the ground");

  GroundSamples samples = by_class ? mean_of_class(octree, classifications, grid, options.progress)
                                   : lowest_points(octree, grid, options.progress);
  geo::Raster<double> heights = heights_in_middles(samples.samples);
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

}  // namespace alidade::visibility
