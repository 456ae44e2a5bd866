// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "extensions/radiation/bounced_light.h"
#include "visibility/sky/sky_of_cloud.h"

namespace alidade::visibility {

/// radiation() as four numbers: hours, beam, diffuse, reflected. With a bounce each side of a point is
/// computed once, for receiving and reflecting.
class RadiationMeasure : public SunMeasure {
 public:
  static constexpr std::size_t k_numbers = 4;

  /// `cell`: of BouncedLight. The references must outlive the object.
  RadiationMeasure(const Occluders& occluders, const EnergyLight& light, const RadiationOptions& options,
                   double cell);

  std::size_t periods() const override { return static_cast<std::size_t>(light_.periods); }
  std::size_t numbers() const override { return k_numbers; }
  std::size_t lines() const override;
  SkyReceiver receiver() const override { return options_.receiver; }
  void answer(std::span<const SkyTarget> targets, std::span<const std::uint64_t> point_ids,
              std::span<float> answers) override;

 private:
  const Occluders& occluders_;
  const EnergyLight& light_;
  RadiationOptions options_;
  std::optional<BouncedLight> bounced_;
};

}  // namespace alidade::visibility
