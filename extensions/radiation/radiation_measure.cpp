// SPDX-License-Identifier: MIT
#include "extensions/radiation/radiation_measure.h"

#include <vector>

#include "extensions/radiation/sky_patches.h"

namespace alidade::visibility {

RadiationMeasure::RadiationMeasure(const Occluders& occluders, const EnergyLight& light,
                                   const RadiationOptions& options, double cell)
    : occluders_(occluders), light_(light), options_(options) {
  if (options.bounces > 0) bounced_.emplace(occluders, light, options, cell);
}

std::size_t RadiationMeasure::lines() const {
  return light_.bins.size() + light_.fans.size() + (bounced_ ? std::size_t{2} * k_sky_patches : 0);
}

void RadiationMeasure::answer(std::span<const SkyTarget> targets, std::span<const std::uint64_t> point_ids,
                              std::span<float> answers) {
  std::vector<Radiation> all(targets.size() * periods());
  RadiationOptions direct = options_;
  if (bounced_) direct.bounces = 0;
  // The irradiance of points on their own surfaces is also what BouncedLight needs of them.
  if (bounced_ && !point_ids.empty() && options_.receiver == SkyReceiver::surface && !options_.normal)
    bounced_->answer_points(targets, point_ids, all);
  else
    radiation(occluders_, targets, light_, direct, all);
  if (bounced_) bounced_->add(targets, all);
  auto next = answers.begin();
  for (const Radiation& one : all)
    for (const float number : {one.hours, one.beam, one.diffuse, one.reflected}) *next++ = number;
}

}  // namespace alidade::visibility
