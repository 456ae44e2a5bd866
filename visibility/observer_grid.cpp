// SPDX-License-Identifier: MIT
#include "visibility/observer_grid.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

#include "base/error.h"

namespace alidade {

std::vector<GivenObserver> observer_grid(const Bounds& extent, double width, const GroundHeight& ground,
                                         const Progress& progress) {
  if (!(width > 0.0 && std::isfinite(width)))
    throw Error({.problem = "the observer grid has no cells", .expected = "a width above 0"});
  // A line of points has an extent of no width, and still a cell.
  const double columns = std::fmax(1.0, std::ceil((extent.max.x - extent.min.x) / width));
  const double rows = std::fmax(1.0, std::ceil((extent.max.y - extent.min.y) / width));
  if (!(columns * rows <= k_most_grid_observers)) {
    throw Error({.problem = fmt::format("the observer grid of {} has too many places", width),
                 .expected = fmt::format("at most {:.0f}", k_most_grid_observers),
                 .found = fmt::format("{:.0f} by {:.0f}", columns, rows)});
  }
  const glm::dvec2 corner(extent.center().x - 0.5 * columns * width, extent.center().y - 0.5 * rows * width);
  std::vector<GivenObserver> observers;
  const auto total = static_cast<std::uint64_t>(columns * rows);
  for (std::uint64_t row = 0; row < static_cast<std::uint64_t>(rows); ++row) {
    for (std::uint64_t column = 0; column < static_cast<std::uint64_t>(columns); ++column) {
      const glm::dvec2 place(corner.x + (static_cast<double>(column) + 0.5) * width,
                             corner.y + (static_cast<double>(row) + 0.5) * width);
      if (!ground(place)) continue;
      observers.push_back(
          {.source = "--observer-grid", .name = fmt::format("{}-{}", row + 1, column + 1), .place = place});
    }
    report(progress, (row + 1) * static_cast<std::uint64_t>(columns), total);
  }
  if (observers.empty())
    throw Error({.problem = "the observer grid has no place with points of the cloud near it"});
  return observers;
}

}  // namespace alidade
