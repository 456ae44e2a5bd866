// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include "base/exact_math.h"

namespace alidade {

/// Unit vector towards an azimuth (degrees clockwise from north, +y) and an elevation (degrees above the
/// horizontal). The same bits on every machine.
inline glm::dvec3 compass_direction(double azimuth, double elevation) {
  const SineCosine turn = sine_cosine_of_degrees(azimuth), rise = sine_cosine_of_degrees(elevation);
  return {turn.sine * rise.cosine, turn.cosine * rise.cosine, rise.sine};
}

}  // namespace alidade
