// SPDX-License-Identifier: MIT
#include "visibility/raster/relief.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace alidade {

Relief::Relief(const Ground& ground, double step) : ground_(ground), step_(step) {
  constexpr int k_samples = 50;
  // Nine slopes in ten shall not look steeper than this.
  constexpr double k_steep = 0.5, k_most = 8.0, k_share = 0.9;
  const RasterGrid& grid = ground.heights().grid;
  const glm::dvec2 size = grid.south_east() - grid.north_west;
  std::vector<double> slopes;
  for (int y = 0; y < k_samples; ++y) {
    for (int x = 0; x < k_samples; ++x) {
      const glm::dvec2 there = slope(grid.north_west + size * ((glm::dvec2(x, y) + 0.5) / double{k_samples}));
      slopes.push_back(std::sqrt(there.x * there.x + there.y * there.y));
    }
  }
  const auto steep = slopes.begin() + static_cast<std::ptrdiff_t>(k_share * k_samples * k_samples);
  std::nth_element(slopes.begin(), steep, slopes.end());
  if (*steep > 0.0) exaggeration_ = std::clamp(k_steep / *steep, 1.0, k_most);
}

glm::dvec2 Relief::slope(const glm::dvec2& place) const {
  const auto height = [&](double x, double y) { return ground_.at(place + step_ * glm::dvec2(x, y)); };
  const auto east = height(1, 0), west = height(-1, 0), north = height(0, 1), south = height(0, -1);
  if (!east || !west || !north || !south) return glm::dvec2(0.0);
  return glm::dvec2(*east - *west, *north - *south) / (2.0 * step_);
}

double Relief::light(const glm::dvec2& place) const {
  const glm::dvec2 rise = exaggeration_ * slope(place);
  // The light comes from (-1, 1, sqrt 2) / 2; divided by its share on level ground.
  const double towards = (rise.x - rise.y) / std::sqrt(2.0) + 1.0;
  return std::max(0.0, towards) / std::sqrt(1.0 + rise.x * rise.x + rise.y * rise.y);
}

}  // namespace alidade
