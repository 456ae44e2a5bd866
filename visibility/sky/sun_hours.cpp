// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_hours.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "geo/earth.h"
#include "visibility/sky/bounced_light.h"

namespace alidade::visibility {
namespace {

/// Sums of a target and period, in double until they are complete.
struct Sums {
  double hours = 0.0, beam = 0.0, diffuse = 0.0;

  void add_to_sphere(const LightSums& light) {
    hours += light.hours;
    beam += 0.25 * glm::length(light.beam);
    diffuse += 0.25 * glm::length(light.diffuse);
  }
  void add(const LightSums& light, const glm::dvec3& normal) {
    hours += light.hours;
    beam += std::max(0.0, glm::dot(light.beam, normal));
    diffuse += std::max(0.0, glm::dot(light.diffuse, normal));
  }
};

void add_bins(const Occluders& occluders, std::span<const SkyTarget> targets, const SunLight& light,
              const SunHoursOptions& options, std::span<Sums> sums) {
  std::vector<std::uint32_t> in_front;
  std::vector<SightLine> lines;
  std::vector<std::uint8_t> is_blocked;
  const auto periods = static_cast<std::size_t>(light.periods);
  for (const LightBin& bin : light.bins) {
    in_front.clear();
    for (std::uint32_t i = 0; i < targets.size(); ++i) {
      const bool is_behind = targets[i].has_surface() && !(glm::dot(bin.direction, targets[i].normal) > 0.0);
      if (!is_behind && (!options.normal || glm::dot(bin.direction, *options.normal) > 0.0))
        in_front.push_back(i);
    }
    if (in_front.empty()) continue;
    lines.resize(in_front.size());
    is_blocked.resize(in_front.size());
    in_parallel(in_front.size(), 1024, [&](std::size_t i) {
      lines[i] = sight_ray(targets[in_front[i]].front, bin.direction, options.max_distance);
    });
    blocked(occluders, lines, is_blocked);
    for (std::size_t i = 0; i < in_front.size(); ++i) {
      if (is_blocked[i] != 0) continue;
      const glm::dvec3 normal = receiver_normal(targets[in_front[i]], options);
      for (const LightBin::Share& share : bin.shares) {
        Sums& sum = sums[in_front[i] * periods + static_cast<std::size_t>(share.period)];
        if (options.is_sphere)
          sum.add_to_sphere(share.sums);
        else
          sum.add(share.sums, normal);
      }
    }
  }
}

void add_fans(const geo::TerrainSurface& terrain, std::span<const SkyTarget> targets, const SunLight& light,
              const SunHoursOptions& options, std::span<Sums> sums) {
  const auto periods = static_cast<std::size_t>(light.periods);
  in_parallel(targets.size(), 16, [&](std::size_t i) {
    const glm::dvec3 normal = receiver_normal(targets[i], options);
    const std::span<Sums> of_target = sums.subspan(i * periods, periods);
    for (const LightFan& fan : light.fans) {
      const double facing = facing_slope(normal, fan.direction);
      if (std::isinf(facing)) continue;
      const double slope = terrain.horizon_slope(targets[i].front.position, fan.direction, facing);
      for (const LightFan::Share& share : fan.shares) {
        const auto end = std::ranges::lower_bound(share.slopes, slope, std::greater<>{});
        const auto count = static_cast<std::size_t>(end - share.slopes.begin());
        of_target[static_cast<std::size_t>(share.period)].add(share.sums[count], normal);
      }
    }
  });
}

}  // namespace

glm::dvec3 receiver_normal(const SkyTarget& target, const SunHoursOptions& options) {
  if (options.normal) return *options.normal;
  const bool is_surface = options.receiver == SkyReceiver::surface && target.has_surface();
  return is_surface ? target.normal : glm::dvec3(0.0, 0.0, 1.0);
}

glm::dvec3 tilted_normal(double tilt, double azimuth) {
  return geo::compass_direction(azimuth, 90.0 - tilt);
}

void sun_hours(const Occluders& occluders, std::span<const SkyTarget> targets, const SunLight& light,
               const SunHoursOptions& options, std::span<Radiation> answers) {
  const auto periods = static_cast<std::size_t>(light.periods);
  assert(targets.size() * periods == answers.size());
  check_that(options.albedo >= 0.0 && options.albedo <= 1.0, "albedo out of range", "0 to 1",
             fmt::format("{}", options.albedo));
  check_that(options.bounces == 0 || options.bounces == 1, "number of bounces out of range", "0 or 1",
             std::to_string(options.bounces));
  check_that(light.fans.empty() || has_horizons(occluders, options.max_distance),
             "horizons cannot replace lines of sight", "a terrain alone and no maximum distance, or bins");
  std::vector<Sums> sums(answers.size());
  if (!light.fans.empty())
    add_fans(*occluders.options().terrain, targets, light, options, sums);
  else
    add_bins(occluders, targets, light, options, sums);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const LightSums& open = light.open[i % periods];
    const double away = 0.5 * (1.0 - receiver_normal(targets[i / periods], options).z);
    answers[i] = {static_cast<float>(sums[i].hours), static_cast<float>(sums[i].beam),
                  static_cast<float>(sums[i].diffuse),
                  static_cast<float>(options.albedo * away * (open.beam.z + open.diffuse.z))};
  }
  if (options.bounces > 0) BouncedLight(occluders, light, options, 0.0).add(targets, answers);
}

}  // namespace alidade::visibility
