// SPDX-License-Identifier: MIT
#include "extensions/radiation/radiation.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cstddef>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "extensions/radiation/bounced_light.h"

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

SunHoursOptions hours_options(const RadiationOptions& options) {
  return {.receiver = options.receiver, .max_distance = options.max_distance, .normal = options.normal};
}

void add_bins(const Occluders& occluders, std::span<const SkyTarget> targets, const EnergyLight& light,
              const RadiationOptions& options, std::span<Sums> sums) {
  const auto periods = static_cast<std::size_t>(light.periods);
  const SunHoursOptions of_hours = hours_options(options);
  LitTargets lit(occluders, targets, of_hours);
  for (const LightBin& bin : light.bins) {
    for (const std::uint32_t i : lit.from(bin.direction)) {
      const glm::dvec3 normal = receiver_normal(targets[i], of_hours);
      for (const LightBin::Share& share : bin.shares) {
        Sums& sum = sums[i * periods + static_cast<std::size_t>(share.period)];
        if (options.is_sphere)
          sum.add_to_sphere(share.sums);
        else
          sum.add(share.sums, normal);
      }
    }
  }
}

void add_fans(const geo::TerrainSurface& terrain, std::span<const SkyTarget> targets,
              const EnergyLight& light, const RadiationOptions& options, std::span<Sums> sums) {
  const auto periods = static_cast<std::size_t>(light.periods);
  in_parallel(targets.size(), 16, [&](std::size_t i) {
    const glm::dvec3 normal = receiver_normal(targets[i], options);
    for_fan_shares(
        terrain, targets[i], normal, light.fans, [&](const LightFan::Share& share, std::size_t count) {
          sums[i * periods + static_cast<std::size_t>(share.period)].add(share.sums[count], normal);
        });
  });
}

}  // namespace

glm::dvec3 receiver_normal(const SkyTarget& target, const RadiationOptions& options) {
  return receiver_normal(target, hours_options(options));
}

void radiation(const Occluders& occluders, std::span<const SkyTarget> targets, const EnergyLight& light,
               const RadiationOptions& options, std::span<Radiation> answers) {
  const auto periods = static_cast<std::size_t>(light.periods);
  assert(targets.size() * periods == answers.size());
  check_that(options.albedo >= 0.0 && options.albedo <= 1.0, "albedo out of range", "0 to 1",
             fmt::format("{}", options.albedo));
  check_that(options.bounces == 0 || options.bounces == 1, "number of bounces out of range", "0 or 1",
             std::to_string(options.bounces));
  check_fans(!light.fans.empty(), occluders, hours_options(options));
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
