// SPDX-License-Identifier: MIT
#include "geo/raster.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/huge_memory.h"
#include "base/words.h"

namespace alidade::geo {
namespace {

/// Whole multiples of the cell size at or beyond both ends.
struct CellRange {
  double begin = 0.0, end = 0.0;
  double count() const { return end - begin; }
};

CellRange cells_over(double low, double high, double cell_size) {
  CellRange range{std::floor(low / cell_size), std::ceil(high / cell_size)};
  if (range.count() < 1.0) range.end = range.begin + 1.0;
  return range;
}

}  // namespace

RasterGrid grid_over(const Bounds& area, double cell_size) {
  check_that(cell_size > 0.0 && std::isfinite(cell_size), "invalid cell size", "a positive length",
             fmt::format("{}", cell_size));
  for (int axis = 0; axis < 2; ++axis) {
    check_that(area.min[axis] <= area.max[axis], "the area of the map is empty", {});
    check_that(std::isfinite(area.min[axis]) && std::isfinite(area.max[axis]),
               "the area of the map is not finite", {});
    // Corners must differ from each other by far more than a rounding.
    constexpr double k_finest = 1e-12;
    check_that(cell_size >= k_finest * std::max(std::fabs(area.min[axis]), std::fabs(area.max[axis])),
               fmt::format("cells of {} are too small for coordinates of this magnitude", cell_size), {});
  }
  const CellRange x = cells_over(area.min.x, area.max.x, cell_size),
                  y = cells_over(area.min.y, area.max.y, cell_size);
  const double most = static_cast<double>(k_most_cells);
  // A side must fit an int as well.
  check_that(x.count() * y.count() <= most && std::max(x.count(), y.count()) < most, "map too large",
             fmt::format("at most {} cells: use larger cells or a smaller area", k_most_cells),
             fmt::format("{:.0f} x {:.0f} = {:.4g} cells of {}", x.count(), y.count(), x.count() * y.count(),
                         cell_size));
  return {{x.begin * cell_size, y.end * cell_size},
          cell_size,
          static_cast<int>(x.count()),
          static_cast<int>(y.count())};
}

Bounds area_of(const RasterGrid& grid) {
  const glm::dvec2 corner = grid.south_east();
  return {{grid.north_west.x, corner.y, 0.0}, {corner.x, grid.north_west.y, 0.0}};
}

RasterGrid part_over(const RasterGrid& grid, const Bounds& area) {
  const auto cells = [&grid](double begin, double end, int count) {
    // A rounding must not add a row of cells that the area only touches.
    constexpr double k_slack = 1e-6;
    const double first = std::clamp(std::floor(begin / grid.cell_size + k_slack), 0.0, count - 1.0);
    const double last = std::clamp(std::ceil(end / grid.cell_size - k_slack), first + 1.0, count + 0.0);
    return std::pair(static_cast<int>(first), static_cast<int>(last - first));
  };
  const auto [column, columns] =
      cells(area.min.x - grid.north_west.x, area.max.x - grid.north_west.x, grid.columns);
  const auto [row, rows] = cells(grid.north_west.y - area.max.y, grid.north_west.y - area.min.y, grid.rows);
  return {{grid.north_west.x + column * grid.cell_size, grid.north_west.y - row * grid.cell_size},
          grid.cell_size,
          columns,
          rows};
}

std::optional<glm::ivec2> cell_at(const RasterGrid& grid, const glm::dvec2& position) {
  const double x = (position.x - grid.north_west.x) / grid.cell_size,
               y = (grid.north_west.y - position.y) / grid.cell_size;
  if (!(x >= 0.0 && x <= grid.columns && y >= 0.0 && y <= grid.rows)) return std::nullopt;
  return glm::ivec2(std::min(static_cast<int>(x), grid.columns - 1),
                    std::min(static_cast<int>(y), grid.rows - 1));
}

Bounds cropped(const Bounds& area, const Bounds& to) {
  Bounds common = area;
  for (int axis = 0; axis < 2; ++axis) {
    common.min[axis] = std::max(area.min[axis], to.min[axis]);
    common.max[axis] = std::min(area.max[axis], to.max[axis]);
    if (!(common.min[axis] <= common.max[axis])) return {};
  }
  return common;
}

void check_map_memory(const RasterGrid& grid, int bands) {
  constexpr std::uint64_t k_bytes = 12;
  check_memory(k_bytes * static_cast<std::uint64_t>(bands) * grid.size(), "the map");
}

// Apart from the writing, so that programs that only check the name do not load GDAL.

void check_raster_name(const std::filesystem::path& file) {
  const std::string extension = file_extension(file);
  if (extension == ".tif" || extension == ".tiff") return;
  throw file_error(file, "unknown output format", "the extension .tif",
                   extension.empty() ? "no extension" : extension);
}

}  // namespace alidade::geo
