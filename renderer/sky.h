// SPDX-License-Identifier: MIT
#pragma once

#include <glm/common.hpp>

#include "renderer/scene.h"
#include "renderer/sky_image.h"

namespace alidade {

/// Radiance that comes from the sky along a unit direction towards it, the sun left out. A sky from a picture
/// must have been read.
inline Rgb sky_radiance(const Sky& sky, const glm::dvec3& direction) {
  if (const auto* constant = std::get_if<ConstantSky>(&sky)) return constant->radiance;
  if (const auto* picture = std::get_if<ImageSky>(&sky)) return picture->image->radiance(direction);
  const auto& gradient = std::get<GradientSky>(sky);
  const double sine_of_elevation = glm::clamp(direction.z, 0.0, 1.0);
  return glm::mix(gradient.horizon, gradient.zenith, static_cast<float>(sine_of_elevation));
}

}  // namespace alidade
