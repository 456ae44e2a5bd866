// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_hours.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "geo/earth.h"

namespace alidade::visibility {

std::vector<SunBin> sun_bins(std::span<const SunStep> steps, double degrees) {
  constexpr double k_widest = 30.0;
  check_that(degrees >= 0.0 && degrees <= k_widest, "bin size of sun positions out of range",
             fmt::format("0 to {} degrees", k_widest), fmt::format("{}", degrees));
  std::vector<SunBin> bins;
  std::vector<glm::dvec3> middles;
  std::map<std::pair<int, int>, std::size_t> known;
  for (const SunStep& step : steps) {
    const glm::dvec3 direction = geo::compass_direction(step.azimuth, step.elevation);
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

namespace {

/// Sums of a target, in double until they are complete.
struct Sums {
  double hours = 0.0, watt_hours = 0.0;
};

}  // namespace

void sun_hours(const Occluders& occluders, std::span<const SkyTarget> targets, std::span<const SunBin> bins,
               const SunHoursOptions& options, std::span<SunHours> answers) {
  assert(targets.size() == answers.size());
  std::vector<Sums> sums(targets.size());
  std::vector<std::uint32_t> asked;
  std::vector<SightLine> lines;
  std::vector<std::uint8_t> is_blocked;
  for (const SunBin& bin : bins) {
    asked.clear();
    for (std::uint32_t i = 0; i < targets.size(); ++i) {
      if (!targets[i].has_surface() || glm::dot(bin.direction, targets[i].normal) > 0.0) asked.push_back(i);
    }
    lines.resize(asked.size());
    is_blocked.resize(asked.size());
    in_parallel(asked.size(), 1024, [&](std::size_t i) {
      lines[i] = sight_ray(targets[asked[i]].front, bin.direction, options.max_distance);
    });
    blocked(occluders, lines, is_blocked);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      if (is_blocked[i] != 0) continue;
      const SkyTarget& target = targets[asked[i]];
      const bool tilted = options.receiver == SkyReceiver::surface && target.has_surface();
      Sums& sum = sums[asked[i]];
      sum.hours += bin.hours;
      sum.watt_hours += std::max(0.0, tilted ? glm::dot(bin.energy, target.normal) : bin.energy.z);
    }
  }
  for (std::size_t i = 0; i < targets.size(); ++i) {
    answers[i] = {static_cast<float>(sums[i].hours), static_cast<float>(sums[i].watt_hours / 1000.0)};
  }
}

}  // namespace alidade::visibility
