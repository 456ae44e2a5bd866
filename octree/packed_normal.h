// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alidade {

/// A direction whose side is free, as two whole numbers in [0, steps], which must be even so that upright
/// stays upright. Source: the octahedral map of Cigolle et al., A Survey of Efficient Representations for
/// Independent Unit Vectors, JCGT 2014; the upper half alone, whose square turned by 45 degrees fills the
/// whole range.
inline glm::uvec2 pack_normal(const glm::dvec3& normal, double steps) {
  const glm::dvec3 n = normal / (std::fabs(normal.x) + std::fabs(normal.y) + std::fabs(normal.z));
  const double sign = n.z < 0.0 ? -1.0 : 1.0;
  const auto step = [&](double place) {
    return static_cast<std::uint32_t>((0.5 + 0.5 * place) * steps + 0.5);
  };
  return {step(sign * (n.x + n.y)), step(sign * (n.x - n.y))};
}

/// Of length 1, z >= 0.
inline glm::dvec3 unpack_normal(const glm::uvec2& packed, double steps) {
  const double u = packed.x / steps * 2.0 - 1.0, v = packed.y / steps * 2.0 - 1.0;
  const double x = 0.5 * (u + v), y = 0.5 * (u - v);
  return glm::normalize(glm::dvec3(x, y, 1.0 - std::fabs(x) - std::fabs(y)));
}

}  // namespace alidade
