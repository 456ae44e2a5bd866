// SPDX-License-Identifier: MIT
#include "visibility/raster/viewshed_area.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "geo/raster.h"

namespace alidade {

Bounds area_in_reach(const Bounds& area, std::span<const Observer> observers) {
  Bounds reached;
  for (const Observer& observer : observers) {
    const glm::dvec3 reach(observer.max_distance);
    reached.grow(cropped(area, {observer.position - reach, observer.position + reach}));
  }
  if (reached.empty()) {
    throw Error({.problem = "no observer reaches the area of the map",
                 .expected = "a place near the cloud, a larger maximum distance, or another area"});
  }
  return reached;
}

double usual_resolution(const Bounds& area, double finest) {
  constexpr double k_cells = 1000.0;
  const glm::dvec3 size = area.size();
  const double least = std::max(std::max(size.x, size.y) / k_cells, finest);
  if (!(least > 0.0)) return 1.0;
  const double exponent = std::floor(std::log10(least));
  const double power = std::pow(10.0, std::fabs(exponent));
  for (const double mantissa : {1.0, 2.0, 5.0}) {
    const double size_of_cell = exponent < 0.0 ? mantissa / power : mantissa * power;
    if (size_of_cell >= least) return size_of_cell;
  }
  return exponent < 0.0 ? 10.0 / power : 10.0 * power;
}

}  // namespace alidade
