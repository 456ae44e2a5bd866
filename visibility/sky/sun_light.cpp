// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_light.h"

#include <fmt/format.h>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "base/exact_math.h"
#include "geo/earth.h"

namespace alidade::visibility {

void check_bin(double degrees) {
  constexpr double k_widest = 30.0;
  check_that(degrees >= 0.0 && degrees <= k_widest, "bin size of sun positions out of range",
             fmt::format("0 to {} degrees", k_widest), fmt::format("{}", degrees));
}

StepBins bins_of_steps(std::span<const SunStep> steps, double degrees) {
  StepBins bins;
  std::vector<glm::dvec3>& sums = bins.directions;    // weighted by hours
  std::map<std::pair<int, int>, std::size_t> bin_at;  // by row and column
  for (const SunStep& step : steps) {
    std::size_t bin = sums.size();
    if (degrees > 0.0) {
      const double row = std::floor(step.elevation / degrees);
      // As many columns as make the bins of the row as wide as high, at its middle.
      const double cosine = sine_cosine_of_degrees(std::fmin((row + 0.5) * degrees, 90.0)).cosine;
      const double columns = std::fmax(1.0, std::floor(360.0 * cosine / degrees + 0.5));
      const double column = std::floor(step.azimuth / 360.0 * columns);
      bin = bin_at.try_emplace({static_cast<int>(row), static_cast<int>(column)}, bin).first->second;
    }
    if (bin == sums.size()) sums.emplace_back(0.0);
    sums[bin] += step.hours * geo::compass_direction(step.azimuth, step.elevation);
    bins.of_step.push_back(bin);
  }
  for (glm::dvec3& direction : sums) direction = glm::normalize(direction);
  return bins;
}

double fan_azimuth(const SunStep& step, double degrees) {
  if (!(degrees > 0.0)) return step.azimuth;
  const int sectors = sectors_of(degrees);
  return (std::floor(step.azimuth / 360.0 * sectors) + 0.5) * 360.0 / sectors;
}

int sectors_of(double degrees) {
  return static_cast<int>(std::fmax(1.0, std::floor(360.0 / degrees + 0.5)));
}

double tangent_of(double elevation) {
  const SineCosine rise = sine_cosine_of_degrees(elevation);
  return rise.sine / rise.cosine;
}

glm::dvec2 fan_direction(double azimuth) {
  return glm::dvec2(geo::compass_direction(azimuth, 0.0));
}

LightOf<SunHours> sun_light(std::span<const SunStep> steps, int periods, const LightOptions& options) {
  check_bin(options.bin);
  const auto hours_of = [&](std::size_t i) { return SunHours{steps[i].hours}; };
  LightOf<SunHours> light{.periods = periods};
  light.open.resize(static_cast<std::size_t>(periods));
  for (const SunStep& step : steps) light.open[static_cast<std::size_t>(step.period)].hours += step.hours;
  if (options.by_horizons) {
    FanLights<SunHours> fans;
    add_sun_fans(steps, options.bin, hours_of, fans);
    light.fans = sorted_fans(std::move(fans));
  } else {
    light.bins = sun_bins<SunHours>(steps, options.bin, hours_of);
  }
  return light;
}

}  // namespace alidade::visibility
