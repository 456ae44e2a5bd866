// SPDX-License-Identifier: MIT
#include "visibility/raster/ground.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace alidade::visibility {

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

}  // namespace alidade::visibility
