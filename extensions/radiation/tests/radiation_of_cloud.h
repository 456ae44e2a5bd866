// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "extensions/radiation/radiation_measure.h"

namespace alidade::test {

/// `numbers` of a RadiationMeasure.
inline std::vector<visibility::Radiation> radiation_of(const HugeVector<float>& numbers) {
  std::vector<visibility::Radiation> all;
  for (std::size_t i = 0; i < numbers.size(); i += visibility::RadiationMeasure::k_numbers)
    all.push_back({numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]});
  return all;
}

/// Of every point: its periods.
inline std::vector<visibility::Radiation> point_radiation(const visibility::Occluders& occluders,
                                                          std::span<const glm::vec3> normals,
                                                          const visibility::EnergyLight& light,
                                                          const visibility::RadiationOptions& options,
                                                          const visibility::LongWork& work = {}) {
  visibility::RadiationMeasure measure(occluders, light, options, 0.0);
  return radiation_of(point_sun(occluders, normals, measure, work));
}

/// Of every cell: its periods.
inline std::vector<visibility::Radiation> ground_radiation(const visibility::Occluders& occluders,
                                                           const visibility::Ground& ground,
                                                           const geo::RasterGrid& grid, double height,
                                                           const visibility::EnergyLight& light,
                                                           const visibility::RadiationOptions& options) {
  visibility::RadiationMeasure measure(occluders, light, options, grid.cell_size);
  return radiation_of(ground_sun(occluders, ground, grid, height, measure));
}

}  // namespace alidade::test
