// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_bins.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "base/error.h"
#include "geo/earth.h"

namespace alidade {

std::vector<SunBin> sun_bins(std::span<const SunStep> steps, double degrees) {
  constexpr double k_widest = 30.0;
  if (!(degrees >= 0.0 && degrees <= k_widest)) {
    throw Error({.problem = "the size of a bin of sun positions is out of range",
                 .expected = fmt::format("0 to {} degrees", k_widest),
                 .found = fmt::format("{}", degrees)});
  }
  std::vector<SunBin> bins;
  std::vector<glm::dvec3> middles;
  std::map<std::pair<int, int>, std::size_t> known;
  for (const SunStep& step : steps) {
    const glm::dvec3 direction = compass_direction(step.azimuth, step.elevation);
    std::size_t bin = bins.size();
    if (degrees > 0.0) {
      const double row = std::floor(step.elevation / degrees);
      // As many columns as keep the bins in the middle of the row as wide as high.
      const double breadth = sine_cosine_of_degrees(std::fmin((row + 0.5) * degrees, 90.0)).cosine;
      const double columns = std::fmax(1.0, std::floor(360.0 * breadth / degrees + 0.5));
      const double column = std::floor(step.azimuth / 360.0 * columns);
      bin = known.try_emplace({static_cast<int>(row), static_cast<int>(column)}, bin).first->second;
    }
    if (bin == bins.size()) {
      bins.emplace_back();
      middles.emplace_back(0.0);
    }
    middles[bin] += step.hours * direction;
    bins[bin].hours += step.hours;
    bins[bin].energy += step.hours * step.irradiance * direction;
  }
  for (std::size_t i = 0; i < bins.size(); ++i) bins[i].direction = glm::normalize(middles[i]);
  return bins;
}

}  // namespace alidade
