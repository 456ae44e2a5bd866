// SPDX-License-Identifier: MIT
#include "visibility/raster/ground.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/parallel.h"
#include "octree/tree_walk.h"

namespace alidade::visibility {
namespace {

constexpr std::uint8_t k_ground_class = 2;  // of ASPRS

/// Whether points of a class lie on the ground: ground, water, road surface. In classified clouds roads and
/// water are mostly classes of their own, and would be holes in the ground.
constexpr bool is_on_ground(std::uint8_t point_class) {
  constexpr std::uint8_t k_water = 9, k_road = 11;
  return point_class == k_ground_class || point_class == k_water || point_class == k_road;
}

/// A height measured somewhere in a cell.
struct GroundSample {
  glm::vec2 offset{0.0f};  ///< from the middle of the cell
  double height = 0.0;     ///< NaN if nothing was measured

  bool exists() const { return height == height; }
};

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

struct GroundSamples {
  GroundSamples(const geo::RasterGrid& grid, const ScratchFolder& scratch)
      : samples(grid, {.height = k_nan}, scratch), covered(grid.size(), 0, scratch) {}

  geo::Raster<GroundSample> samples;
  HugeVector<std::uint8_t> covered;  ///< cells with points of any class
};

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

/// Calls visit(column, row) for the cells around one that are in the grid.
template <class Visit>
void for_each_neighbour(const geo::RasterGrid& grid, int column, int row, const Visit& visit) {
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, grid.rows - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, grid.columns - 1); ++x) {
      if (x != column || y != row) visit(x, y);
    }
  }
}

/// Whether another low point of the cell or around it is not much higher than its lowest.
bool has_company(const geo::Raster<TwoLowest>& lowest, int column, int row) {
  const double most = 1.0 + lowest.grid.cell_size;
  const TwoLowest& cell = lowest.at(column, row);
  bool found = cell.second.height - cell.lowest.height <= most;
  for_each_neighbour(lowest.grid, column, row, [&](int x, int y) {
    found = found || lowest.at(x, y).lowest.height - cell.lowest.height <= most;
  });
  return found;
}

/// Slope of the ground around a cell: least squares over the differences to the cells around it. Zero if
/// these do not determine it.
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
  // Neighbours on one line, or near it, determine the slope across it only by noise: they must be spread by
  // half a cell in every direction.
  constexpr double k_least_spread = 0.25;
  const double determinant = xx * yy - xy * xy, spread = xx + yy;
  if (!(spread > 0.0 && determinant >= k_least_spread * grid.cell_size * grid.cell_size * spread))
    return glm::dvec2(0.0);
  return {(yy * xz - xy * yz) / determinant, (xx * yz - xy * xz) / determinant};
}

/// For every cell, the mean of its points of classes on the ground.
GroundSamples mean_of_class(const Octree& octree, std::span<const std::uint8_t> classifications,
                            const geo::RasterGrid& grid, const Progress& progress) {
  struct Sum {
    glm::dvec2 offset{0.0};
    double height = 0.0;
    std::uint64_t count = 0;
  };
  geo::Raster<Sum> sums(grid, {}, octree.scratch());
  GroundSamples result(grid, octree.scratch());
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

/// For every cell, the lowest point that is not an outlier; with a sign of -1 the highest.
GroundSamples lowest_points(const Octree& octree, const geo::RasterGrid& grid, double sign,
                            const Progress& progress) {
  geo::Raster<TwoLowest> lowest(grid, {}, octree.scratch());
  GroundSamples result(grid, octree.scratch());
  for_each_point(octree, grid, progress, [&](const glm::ivec2& cell, std::uint64_t, const glm::dvec3& p) {
    result.covered[grid.index(cell.x, cell.y)] = 1;
    lowest.at(cell.x, cell.y).take(sample_at(grid, cell, {p.x, p.y, sign * p.z}));
  });
  in_parallel(grid.rows, 4, [&](int row) {
    for (int column = 0; column < grid.columns; ++column) {
      const TwoLowest& cell = lowest.at(column, row);
      GroundSample& sample = result.samples.at(column, row);
      sample = has_company(lowest, column, row) ? cell.lowest : cell.second;
      sample.height *= sign;
    }
  });
  return result;
}

/// Heights in the middles of cells; NaN where nothing was measured. Steeper slopes than `steepest` are steps,
/// such as the edge of a roof.
geo::Raster<double> heights_in_middles(const geo::Raster<GroundSample>& samples, double steepest,
                                       const ScratchFolder& scratch) {
  geo::Raster<double> heights(samples.grid, k_nan, scratch);
  in_parallel(samples.grid.rows, 4, [&](int row) {
    for (int column = 0; column < samples.grid.columns; ++column) {
      const GroundSample& sample = samples.at(column, row);
      if (!sample.exists()) continue;
      glm::dvec2 slope = slope_around(samples, column, row);
      if (glm::dot(slope, slope) > steepest * steepest) slope = glm::dvec2(0.0);
      heights.at(column, row) = sample.height - slope.x * sample.offset.x - slope.y * sample.offset.y;
    }
  });
  return heights;
}

// fill_gaps(): the membrane over the gaps.

struct Level {
  geo::Raster<double> heights;
  HugeVector<std::uint8_t> known;

  int columns() const { return heights.grid.columns; }
  int rows() const { return heights.grid.rows; }
  double value(int column, int row) const {
    return heights.at(std::clamp(column, 0, columns() - 1), std::clamp(row, 0, rows() - 1));
  }
};

/// A level with half as many columns and rows; a cell is known if one of its four is.
Level coarser(const Level& fine) {
  geo::RasterGrid grid = fine.heights.grid;
  grid.columns = (grid.columns + 1) / 2;
  grid.rows = (grid.rows + 1) / 2;
  grid.cell_size *= 2.0;
  Level level{{grid, 0.0, fine.heights.values.get_allocator()},
              HugeVector<std::uint8_t>(grid.size(), 0, fine.known.get_allocator())};
  in_parallel(grid.rows, 4, [&](int row) {
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

/// Fills unknown cells from the level above, bilinear between the middles of its cells.
void start_from(const Level& coarse, Level& fine) {
  in_parallel(fine.rows(), 4, [&](int row) {
    for (int column = 0; column < fine.columns(); ++column) {
      const std::size_t i = fine.heights.grid.index(column, row);
      if (fine.known[i]) continue;
      // The middle of a cell is a quarter of the larger cell away from that cell's middle.
      const int x = column / 2, y = row / 2;
      const int beside = column % 2 == 0 ? x - 1 : x + 1, above = row % 2 == 0 ? y - 1 : y + 1;
      fine.heights.values[i] = 0.5625 * coarse.value(x, y) + 0.1875 * coarse.value(beside, y) +
                               0.1875 * coarse.value(x, above) + 0.0625 * coarse.value(beside, above);
    }
  });
}

/// Sets every unknown cell of one colour to the mean of its four neighbours, which are of the other colour.
void sweep(Level& level, int color) {
  in_parallel(level.rows(), 4, [&](int row) {
    for (int column = (row + color) % 2; column < level.columns(); column += 2) {
      const std::size_t i = level.heights.grid.index(column, row);
      if (level.known[i]) continue;
      // The surface is flat across the edge of the grid: neighbours outside of it do not count.
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

/// Sets the cells within so many cells of one that is set, along rows or columns.
void widen(HugeVector<std::uint8_t>& set, std::size_t count, std::size_t stride, std::size_t lines,
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

void widen(HugeVector<std::uint8_t>& set, const geo::RasterGrid& grid, double reach) {
  const double most = static_cast<double>(std::max(grid.columns, grid.rows));
  const int cells = static_cast<int>(std::min(std::ceil(reach / grid.cell_size), most));
  const auto columns = static_cast<std::size_t>(grid.columns), rows = static_cast<std::size_t>(grid.rows);
  widen(set, columns, 1, rows, columns, cells);
  widen(set, rows, columns, columns, 1, cells);
}

GroundSource chosen_source(GroundSource requested, bool is_classified) {
  check_that(requested != GroundSource::terrain, "a terrain is not the ground of points",
             "another source, and Ground::raise_to()");
  check_that(requested != GroundSource::classified || is_classified, "missing ground class",
             "points of class 2", "none in the cloud");
  if (requested != GroundSource::automatic) return requested;
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

Ground::Ground(const geo::TerrainSurface& terrain) : reach_(0.0), source_(GroundSource::terrain) {
  const geo::Raster<float>& heights = terrain.heights();
  heights_.grid = heights.grid;
  heights_.values.assign(heights.values.begin(), heights.values.end());
  measured_cells_ = static_cast<std::uint64_t>(
      std::ranges::count_if(heights.values, [](float height) { return !std::isnan(height); }));
}

std::optional<double> Ground::at(const glm::dvec2& position) const {
  const std::optional<double> own = own_at(position);
  if (terrain_ == nullptr) return own;
  const std::optional<double> other = terrain_->at(position);
  return own && other ? std::max(*own, *other) : own ? own : other;
}

bool Ground::is_scanned(const glm::dvec2& position) const {
  if (terrain_ != nullptr && terrain_->is_scanned(position)) return true;
  // The grid's outer edge belongs to its outermost cells, as it does in at().
  const geo::RasterGrid& grid = heights_.grid;
  const double margin = std::min(reach_, grid.cell_size);
  const glm::dvec2 corner = grid.south_east();
  if (position.x < grid.north_west.x - margin || position.x > corner.x + margin ||
      position.y < corner.y - margin || position.y > grid.north_west.y + margin)
    return false;
  const std::optional<glm::ivec2> cell =
      geo::cell_at(grid, {std::clamp(position.x, grid.north_west.x, corner.x),
                          std::clamp(position.y, corner.y, grid.north_west.y)});
  if (!cell) return false;
  return scanned_.empty() ? !std::isnan(heights_.at(cell->x, cell->y))
                          : scanned_[grid.index(cell->x, cell->y)] != 0;
}

std::optional<double> Ground::own_at(const glm::dvec2& position) const {
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

double unscanned_length(const Ground& ground, const glm::dvec2& from, const glm::dvec2& to) {
  constexpr double k_most_steps = 1e6;
  const double length = glm::distance(from, to), step = 0.5 * ground.heights().grid.cell_size;
  const int steps = static_cast<int>(std::clamp(std::ceil(length / step), 1.0, k_most_steps));
  int unscanned = 0;
  for (int i = 0; i < steps; ++i)
    unscanned += ground.is_scanned(from + (i + 0.5) / steps * (to - from)) ? 0 : 1;
  return length * unscanned / steps;
}

void fill_gaps(geo::Raster<double>& raster) {
  constexpr int k_sweeps = 24;
  std::vector<Level> levels(1);
  levels[0].known = HugeVector<std::uint8_t>(raster.values.size(), 0, raster.values.get_allocator());
  for (std::size_t i = 0; i < raster.values.size(); ++i) levels[0].known[i] = !std::isnan(raster.values[i]);
  if (std::ranges::find(levels[0].known, 1) == levels[0].known.end()) return;
  levels[0].heights = std::move(raster);
  while (std::ranges::find(levels.back().known, 0) != levels.back().known.end())
    levels.push_back(coarser(levels.back()));
  for (std::size_t i = levels.size() - 1; i-- > 0;) {
    start_from(levels[i + 1], levels[i]);
    for (int k = 0; k < k_sweeps; ++k) {
      sweep(levels[i], 0);
      sweep(levels[i], 1);
    }
  }
  raster = std::move(levels[0].heights);
}

Ground make_ground(const Octree& octree, std::span<const std::uint8_t> classifications,
                   const GroundOptions& options) {
  constexpr std::uint64_t k_bytes_per_cell = 50;
  constexpr double k_lowest_distances = 4.0, k_highest_distances = 2.0, k_steepest_roof = 1.5;
  if (octree.size() == 0) throw Error({.problem = "the cloud has no points for the ground"});
  for (const double reach : {options.reach, options.scanned_reach.value_or(0.0)})
    check_that(reach >= 0.0 && std::isfinite(reach), "ground reach out of range", "at least 0",
               fmt::format("{}", reach));
  const GroundSource source = chosen_source(
      options.source, std::ranges::find(classifications, k_ground_class) != classifications.end());
  const bool by_class = source == GroundSource::classified, is_highest = source == GroundSource::highest;
  const auto count = by_class
                         ? static_cast<std::uint64_t>(std::ranges::count_if(classifications, is_on_ground))
                         : octree.size();
  const double distance = mean_distance(octree.bounds(), count);
  const double distances = by_class ? 1.0 : is_highest ? k_highest_distances : k_lowest_distances;
  const geo::RasterGrid grid =
      geo::grid_over(octree.bounds(), options.cell_size.value_or(distances * distance));
  if (!octree.scratch()) check_memory(k_bytes_per_cell * grid.size(), "the heights of the ground");

  GroundSamples samples = by_class ? mean_of_class(octree, classifications, grid, options.progress)
                                   : lowest_points(octree, grid, is_highest ? -1.0 : 1.0, options.progress);
  geo::Raster<double> heights = heights_in_middles(
      samples.samples, is_highest ? k_steepest_roof : std::numeric_limits<double>::infinity(),
      octree.scratch());
  samples.samples = {};
  const auto measured = static_cast<std::uint64_t>(
      std::ranges::count_if(heights.values, [](double height) { return !std::isnan(height); }));
  fill_gaps(heights);
  constexpr double k_cells = 3.0, k_least = 1.0;
  HugeVector<std::uint8_t> scanned = samples.covered;
  const double usual = std::min(std::max(k_cells * grid.cell_size, k_least), options.reach);
  widen(scanned, grid, options.scanned_reach.value_or(usual));
  widen(samples.covered, grid, options.reach);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (!samples.covered[i]) heights.values[i] = k_nan;
  }
  return Ground(std::move(heights), options.reach, source, measured, std::move(scanned));
}

}  // namespace alidade::visibility
