// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <optional>

#include "extensions/radiation/irradiance.h"
#include "jobs/visibility/sun_measure.h"

namespace alidade::jobs {

/// The fields on light of the job on the sun.
struct RadiationRequest {
  visibility::ClearAir air;
  std::optional<std::array<double, 12>> monthly_turbidity;
  std::filesystem::path weather;  ///< empty: a clear sky
  bool beam_only = false;
  double albedo = 0.2;
  int bounces = 0;
};

/// Radiation of receivers beside hours.
class AddedRadiation : public AddedSunMeasure {
 public:
  RadiationRequest request;

  void add_fields(const Fields& fields) override;
  void check() const override;
  std::filesystem::path input() const override { return request.weather; }
  std::span<const SunQuantity> quantities() const override;
  /// Its errors: those of visibility::Weather.
  std::unique_ptr<SunShine> shine() const override;
};

}  // namespace alidade::jobs
