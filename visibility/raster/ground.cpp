// SPDX-License-Identifier: MIT
#include "visibility/raster/ground.h"

#include <algorithm>
#include <cmath>

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

}  // namespace alidade::visibility
