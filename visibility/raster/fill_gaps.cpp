// SPDX-License-Identifier: MIT
#include "visibility/raster/fill_gaps.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace alidade {
namespace {

struct Level {
  Raster<double> heights;
  std::vector<std::uint8_t> known;

  int columns() const { return heights.grid.columns; }
  int rows() const { return heights.grid.rows; }
  double value(int column, int row) const {
    return heights.at(std::clamp(column, 0, columns() - 1), std::clamp(row, 0, rows() - 1));
  }
};

/// Half as many cells each way; a cell is known if one of its four is.
Level coarser(const Level& fine) {
  RasterGrid grid = fine.heights.grid;
  grid.columns = (grid.columns + 1) / 2;
  grid.rows = (grid.rows + 1) / 2;
  grid.cell_size *= 2.0;
  Level level{Raster<double>(grid, 0.0), std::vector<std::uint8_t>(grid.size(), 0)};
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

void fill_gaps(Raster<double>& raster) {
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

}  // namespace alidade
