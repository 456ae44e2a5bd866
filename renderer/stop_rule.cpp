// SPDX-License-Identifier: MIT
#include "renderer/stop_rule.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "image/srgb.h"

namespace alidade {
namespace {

/// The noise of a tile and its neighbours together.
Noise noise_around(const TileGrid& grid, const std::vector<Noise>& noise, std::size_t tile) {
  const int column = grid.column_of(tile), row = grid.row_of(tile);
  Noise sum;
  for (int r = std::max(0, row - 1); r <= std::min(grid.rows() - 1, row + 1); ++r)
    for (int c = std::max(0, column - 1); c <= std::min(grid.columns() - 1, column + 1); ++c)
      sum += noise[grid.tile_at(c, r)];
  return sum;
}

}  // namespace

void StopRule::apply(PictureState& state) {
  noise_.resize(state.tiles.size());
  tbb::parallel_for(std::size_t{0}, state.tiles.size(), [&](std::size_t tile) {
    // Tiles that have stopped stay as they are.
    if (!state.tiles[tile].stopped || noise_[tile].pixels == 0) noise_[tile] = tile_noise(state, tile);
  });
  for (std::size_t tile = 0; tile < state.tiles.size(); ++tile) {
    TileState& reached = state.tiles[tile];
    reached.stopped =
        reached.stopped || (reached.samples >= k_fewest_samples && noise_[tile].error(floor_) <= target_ &&
                            noise_around(state.grid, noise_, tile).error(floor_) <= target_);
  }
}

double StopRule::expected_samples(const PictureState& state, std::size_t tile, double most) const {
  const TileState& reached = state.tiles[tile];
  const double samples = reached.samples;
  if (reached.stopped || noise_.empty()) return reached.stopped ? samples : most;
  const double factor = noise_[tile].error(floor_) / target_;
  return std::clamp(samples * factor * factor, std::min(samples + 1.0, most), most);
}

double noise_floor(double exposure) {
  return 0.01 / exposure_scale(exposure);
}

ReachedNoise reached_noise(const PictureState& state, double floor) {
  std::vector<double> errors(state.tiles.size());
  tbb::parallel_for(std::size_t{0}, errors.size(),
                    [&](std::size_t tile) { errors[tile] = tile_noise(state, tile).error(floor); });
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::ranges::nth_element(errors, middle);
  return {*middle, *std::ranges::max_element(errors)};
}

}  // namespace alidade
