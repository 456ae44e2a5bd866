// SPDX-License-Identifier: MIT
#include "tests/visibility/ascii_grid.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>

namespace alidade::test {

using namespace geo;

Raster<double> read_ascii_grid(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::map<std::string, double> head;
  std::string word;
  for (int i = 0; i < 6; ++i) {
    double value = 0.0;
    stream >> word >> value;
    head[word] = value;
  }
  RasterGrid grid;
  grid.columns = static_cast<int>(head.at("cols:"));
  grid.rows = static_cast<int>(head.at("rows:"));
  grid.cell_size = (head.at("east:") - head.at("west:")) / grid.columns;
  grid.north_west = {head.at("west:"), head.at("north:")};
  Raster<double> raster(grid, std::numeric_limits<double>::quiet_NaN());
  for (double& value : raster.values) {
    stream >> word;
    if (word != "*") value = std::stod(word);
  }
  return raster;
}

double interpolated(const Raster<double>& raster, const glm::dvec2& position) {
  const RasterGrid& grid = raster.grid;
  const double x = std::clamp((position.x - grid.north_west.x) / grid.cell_size - 0.5, 0.0,
                              grid.columns - 1.0),
               y = std::clamp((grid.north_west.y - position.y) / grid.cell_size - 0.5, 0.0, grid.rows - 1.0);
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const int east = std::min(column + 1, grid.columns - 1), south = std::min(row + 1, grid.rows - 1);
  const double u = x - column, v = y - row;
  return (1 - v) * ((1 - u) * raster.at(column, row) + u * raster.at(east, row)) +
         v * ((1 - u) * raster.at(column, south) + u * raster.at(east, south));
}

PointCloud cloud_on(const Raster<double>& raster, double spacing) {
  const RasterGrid& grid = raster.grid;
  PointCloud cloud;
  cloud.lattice = {glm::dvec3(0.0001), {grid.north_west.x, grid.south_east().y, 0.0}};
  for (double y = grid.south_east().y + 0.5 * spacing; y < grid.north_west.y; y += spacing) {
    for (double x = grid.north_west.x + 0.5 * spacing; x < grid.south_east().x; x += spacing)
      cloud.positions.push_back(*to_lattice(cloud.lattice, {x, y, interpolated(raster, {x, y})}));
  }
  cloud.classifications.assign(cloud.positions.size(), 2);
  return cloud;
}

}  // namespace alidade::test
