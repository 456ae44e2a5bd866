// SPDX-License-Identifier: MIT
#include "visibility/raster/ground_samples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "octree/tree_walk.h"

namespace alidade::visibility {
namespace {

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

/// Calls visit(cell, point id, world position) for every point.
template <class Visit>
void for_each_point(const Octree& octree, const geo::RasterGrid& grid, const Progress& progress,
                    const Visit& visit) {
  constexpr std::uint64_t k_points_per_report = 1 << 20;
  const TreeView& tree = octree.view();
  std::uint64_t done = 0, next_report = k_points_per_report;
  for_each_leaf(tree, [&](const Leaf& leaf) {
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      const glm::dvec3 position = to_world(tree.lattice, position_of(tree, leaf, i));
      if (const auto cell = geo::cell_at(grid, {position.x, position.y}))
        visit(*cell, point_id(tree, leaf.first + i), position);
    }
    done += leaf.count;
    if (done < next_report) return;
    report(progress, done, tree.point_count);
    next_report = done + k_points_per_report;
  });
  report(progress, done, tree.point_count);
}

GroundSample sample_at(const geo::RasterGrid& grid, const glm::ivec2& cell, const glm::dvec3& position) {
  const glm::dvec2 middle = grid.center(cell.x, cell.y);
  return {{position.x - middle.x, position.y - middle.y}, position.z};
}

struct TwoLowest {
  GroundSample lowest{.height = k_nan}, second{.height = k_nan};

  void take(const GroundSample& sample) {
    if (!(sample.height >= lowest.height)) {
      second = lowest;
      lowest = sample;
    } else if (!(sample.height >= second.height)) {
      second = sample;
    }
  }
};

/// Calls visit(column, row) for the cells around one, as far as there are any.
template <class Visit>
void for_each_neighbour(const geo::RasterGrid& grid, int column, int row, const Visit& visit) {
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, grid.rows - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, grid.columns - 1); ++x) {
      if (x != column || y != row) visit(x, y);
    }
  }
}

/// Whether another low point is not much higher than the cell's lowest.
bool has_company(const geo::Raster<TwoLowest>& lowest, int column, int row) {
  const double most = 1.0 + lowest.grid.cell_size;
  const TwoLowest& cell = lowest.at(column, row);
  bool found = cell.second.height - cell.lowest.height <= most;
  for_each_neighbour(lowest.grid, column, row, [&](int x, int y) {
    found = found || lowest.at(x, y).lowest.height - cell.lowest.height <= most;
  });
  return found;
}

/// Slope of the ground around a cell: least squares over the differences to the cells around it. Zero where
/// these do not decide it.
glm::dvec2 slope_around(const geo::Raster<GroundSample>& samples, int column, int row) {
  const geo::RasterGrid& grid = samples.grid;
  const GroundSample& here = samples.at(column, row);
  double xx = 0.0, xy = 0.0, yy = 0.0, xz = 0.0, yz = 0.0;
  for_each_neighbour(grid, column, row, [&](int x, int y) {
    const GroundSample& there = samples.at(x, y);
    if (!there.exists()) return;
    const double dx = (x - column) * grid.cell_size + there.offset.x - here.offset.x,
                 dy = (row - y) * grid.cell_size + there.offset.y - here.offset.y,
                 dz = there.height - here.height;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
    xz += dx * dz;
    yz += dy * dz;
  });
  // Neighbours on one line, or close by, say nothing about the slope across it but noise: they must be spread
  // by half a cell in every direction.
  constexpr double k_least_spread = 0.25;
  const double determinant = xx * yy - xy * xy;
  const double spread = xx + yy;
  if (!(spread > 0.0 && determinant >= k_least_spread * grid.cell_size * grid.cell_size * spread))
    return glm::dvec2(0.0);
  return {(yy * xz - xy * yz) / determinant, (xx * yz - xy * xz) / determinant};
}

}  // namespace

GroundSamples mean_of_class(const Octree& octree, std::span<const std::uint8_t> classifications,
                            const geo::RasterGrid& grid, const Progress& progress) {
  struct Sum {
    glm::dvec2 offset{0.0};
    double height = 0.0;
    std::uint64_t count = 0;
  };
  geo::Raster<Sum> sums(grid, {});
  GroundSamples result{geo::Raster<GroundSample>(grid, {.height = k_nan}),
                       std::vector<std::uint8_t>(grid.size(), 0)};
  // Sums of heights above the lowest point keep more digits.
  const double base = octree.bounds().min.z;
  for_each_point(octree, grid, progress, [&](const glm::ivec2& cell, std::uint64_t id, const glm::dvec3& p) {
    result.covered[grid.index(cell.x, cell.y)] = 1;
    if (!is_on_ground(classifications[id])) return;
    const GroundSample sample = sample_at(grid, cell, p);
    Sum& sum = sums.at(cell.x, cell.y);
    sum.offset += glm::dvec2(sample.offset);
    sum.height += p.z - base;
    ++sum.count;
  });
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const Sum& sum = sums.values[i];
    if (sum.count == 0) continue;
    const double count = static_cast<double>(sum.count);
    result.samples.values[i] = {glm::vec2(sum.offset / count), base + sum.height / count};
  }
  return result;
}

GroundSamples lowest_points(const Octree& octree, const geo::RasterGrid& grid, const Progress& progress) {
  geo::Raster<TwoLowest> lowest(grid, {});
  GroundSamples result{geo::Raster<GroundSample>(grid, {.height = k_nan}),
                       std::vector<std::uint8_t>(grid.size(), 0)};
  for_each_point(octree, grid, progress, [&](const glm::ivec2& cell, std::uint64_t, const glm::dvec3& p) {
    result.covered[grid.index(cell.x, cell.y)] = 1;
    lowest.at(cell.x, cell.y).take(sample_at(grid, cell, p));
  });
  tbb::parallel_for(0, grid.rows, [&](int row) {
    for (int column = 0; column < grid.columns; ++column) {
      const TwoLowest& cell = lowest.at(column, row);
      result.samples.at(column, row) = has_company(lowest, column, row) ? cell.lowest : cell.second;
    }
  });
  return result;
}

geo::Raster<double> heights_in_middles(const geo::Raster<GroundSample>& samples) {
  geo::Raster<double> heights(samples.grid, k_nan);
  tbb::parallel_for(0, samples.grid.rows, [&](int row) {
    for (int column = 0; column < samples.grid.columns; ++column) {
      const GroundSample& sample = samples.at(column, row);
      if (!sample.exists()) continue;
      const glm::dvec2 slope = slope_around(samples, column, row);
      heights.at(column, row) = sample.height - slope.x * sample.offset.x - slope.y * sample.offset.y;
    }
  });
  return heights;
}

}  // namespace alidade::visibility
