// SPDX-License-Identifier: MIT
#include "visibility/sky/sun_hours.h"

#include <cassert>
#include <cstddef>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "base/parallel.h"
#include "geo/earth.h"

namespace alidade::visibility {

glm::dvec3 receiver_normal(const SkyTarget& target, const SunHoursOptions& options) {
  if (options.normal) return *options.normal;
  const bool is_surface = options.receiver == SkyReceiver::surface && target.has_surface();
  return is_surface ? target.normal : glm::dvec3(0.0, 0.0, 1.0);
}

glm::dvec3 tilted_normal(double tilt, double azimuth) {
  return geo::compass_direction(azimuth, 90.0 - tilt);
}

std::span<const std::uint32_t> LitTargets::from(const glm::dvec3& direction) {
  lit_.clear();
  for (std::uint32_t i = 0; i < targets_.size(); ++i) {
    const bool is_behind = targets_[i].has_surface() && !(glm::dot(direction, targets_[i].normal) > 0.0);
    if (!is_behind && (!options_.normal || glm::dot(direction, *options_.normal) > 0.0)) lit_.push_back(i);
  }
  if (lit_.empty()) return {};
  lines_.resize(lit_.size());
  is_blocked_.resize(lit_.size());
  in_parallel(lit_.size(), 1024, [&](std::size_t i) {
    lines_[i] = sight_ray(targets_[lit_[i]].front, direction, options_.max_distance);
  });
  blocked(occluders_, lines_, is_blocked_);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lit_.size(); ++i)
    if (is_blocked_[i] == 0) lit_[kept++] = lit_[i];
  lit_.resize(kept);
  return lit_;
}

void check_fans(bool has_fans, const Occluders& occluders, const SunHoursOptions& options) {
  check_that(!has_fans || has_horizons(occluders, options.max_distance),
             "horizons cannot replace lines of sight", "a terrain alone and no maximum distance, or bins");
}

void sun_hours(const Occluders& occluders, std::span<const SkyTarget> targets, const LightOf<SunHours>& light,
               const SunHoursOptions& options, std::span<float> answers) {
  const auto periods = static_cast<std::size_t>(light.periods);
  assert(targets.size() * periods == answers.size());
  check_fans(!light.fans.empty(), occluders, options);
  std::vector<double> sums(answers.size());
  if (!light.fans.empty()) {
    in_parallel(targets.size(), 16, [&](std::size_t i) {
      for_fan_shares(*occluders.options().terrain, targets[i], receiver_normal(targets[i], options),
                     light.fans, [&](const FanOf<SunHours>::Share& share, std::size_t count) {
                       sums[i * periods + static_cast<std::size_t>(share.period)] += share.sums[count].hours;
                     });
    });
  }
  LitTargets lit(occluders, targets, options);
  for (const BinOf<SunHours>& bin : light.bins) {
    for (const std::uint32_t i : lit.from(bin.direction))
      for (const BinOf<SunHours>::Share& share : bin.shares)
        sums[i * periods + static_cast<std::size_t>(share.period)] += share.sums.hours;
  }
  for (std::size_t i = 0; i < answers.size(); ++i) answers[i] = static_cast<float>(sums[i]);
}

}  // namespace alidade::visibility
