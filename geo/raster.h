// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <optional>

#include "base/bounds.h"
#include "base/huge_memory.h"

namespace alidade::geo {

/// No map has more cells than this, 2^31.
constexpr std::uint64_t k_most_cells = std::uint64_t{1} << 31;

/// The cells of a map: squares in rows, north (+y) up. A value applies to the whole cell (GDAL's "pixel is
/// area").
struct RasterGrid {
  glm::dvec2 north_west{0.0};  ///< outer corner of row 0, column 0
  double cell_size = 1.0;      ///< side of a cell, in the unit of the cloud
  int columns = 0, rows = 0;   ///< row 0 is the northernmost

  std::size_t size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  glm::dvec2 center(int column, int row) const {
    return {north_west.x + (column + 0.5) * cell_size, north_west.y - (row + 0.5) * cell_size};
  }
  glm::dvec2 south_east() const {
    return {north_west.x + columns * cell_size, north_west.y - rows * cell_size};
  }

  bool operator==(const RasterGrid&) const = default;
};

/// A value for every cell, row after row.
template <class Value>
struct Raster {
  RasterGrid grid;
  HugeVector<Value> values;

  Raster() = default;
  Raster(const RasterGrid& on, Value value, const PageAllocator<Value>& pages = {})
      : grid(on), values(on.size(), value, pages) {}

  Value& at(int column, int row) { return values[grid.index(column, row)]; }
  const Value& at(int column, int row) const { return values[grid.index(column, row)]; }
};

/// The cells that cover an area (x and y of it; z does not matter), at least one. Their corners lie on whole
/// multiples of the cell size, so that maps of one cell size fit on each other. Errors: the area is empty or
/// not finite; cell_size not above 0 or not finite, or too fine for such large coordinates; more than
/// k_most_cells cells, with their number.
RasterGrid grid_over(const Bounds& area, double cell_size);

/// The area of a grid, to the outer edges of its cells; z is 0.
Bounds area_of(const RasterGrid& grid);

/// The cells of a grid that hold an area, in x and y; at least one. The part of the area outside of the grid
/// is ignored. Requires: a cell in the grid.
RasterGrid part_over(const RasterGrid& grid, const Bounds& area);

/// The cell that contains a position; one on the edge of two is in the eastern or southern cell, one on the
/// outer edges in the outermost. Empty outside of the grid.
std::optional<glm::ivec2> cell_at(const RasterGrid& grid, const glm::dvec2& position);

/// The intersection of two areas, in x and y; may be empty. z is that of `area`.
Bounds cropped(const Bounds& area, const Bounds& to);

/// check_memory() for a map of so many bands of up to 4 bytes, with what making and writing it takes: 12 B
/// per cell and band.
void check_map_memory(const RasterGrid& grid, int bands);

/// Errors: the name does not end in .tif or .tiff.
void check_raster_name(const std::filesystem::path& file);

}  // namespace alidade::geo
