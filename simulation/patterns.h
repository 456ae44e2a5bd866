// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "simulation/noise.h"

// What the colours of a site are put together from. Only +, -, *, / and floor, see finish.h.

namespace alidade::patterns {

/// Eases from 0 at `low` to 1 at `high`.
inline double step_between(double low, double high, double x) {
  const double place = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return place * place * (3.0 - 2.0 * place);
}

inline glm::dvec3 blend(const glm::dvec3& from, const glm::dvec3& to, double share) {
  return from + share * (to - from);
}

/// Noise around 0, from -1 to 1, with features of `size` metres.
inline double blotches(const glm::dvec3& position, double size, std::uint32_t seed) {
  return 2.0 * smooth_noise(position / size, seed) - 1.0;
}

inline double fraction(double x) {
  return x - std::floor(x);
}

/// Rows of stones, each row shifted by half a stone: brightness of one stone and how much of the place is
/// joint.
struct Stone {
  double shade = 0.0;  ///< -1 .. 1, the same all over a stone
  double joint = 0.0;  ///< 0 on the stone, 1 in the joint
};

inline Stone stone_at(const glm::dvec2& place, const glm::dvec2& size, double joint_width,
                      std::uint32_t seed) {
  const double row = std::floor(place.y / size.y);
  const double along = place.x / size.x + fraction(0.5 * row);
  const double to_joint_x = (0.5 - std::fabs(fraction(along) - 0.5)) * size.x;
  const double to_joint_y = (0.5 - std::fabs(fraction(place.y / size.y) - 0.5)) * size.y;
  return {2.0 * cell_noise(along, row, seed) - 1.0,
          1.0 - step_between(0.25 * joint_width, joint_width, std::min(to_joint_x, to_joint_y))};
}

}  // namespace alidade::patterns
