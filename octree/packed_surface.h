// SPDX-License-Identifier: MIT
#pragma once

#include <array>
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
  const auto step = [&](double side) { return static_cast<std::uint32_t>((0.5 + 0.5 * side) * steps + 0.5); };
  return {step(sign * (n.x + n.y)), step(sign * (n.x - n.y))};
}

/// Of length 1, z >= 0.
inline glm::dvec3 unpack_normal(const glm::uvec2& packed, double steps) {
  const double u = packed.x / steps * 2.0 - 1.0, v = packed.y / steps * 2.0 - 1.0;
  const double x = 0.5 * (u + v), y = 0.5 * (u - v);
  return glm::normalize(glm::dvec3(x, y, 1.0 - std::fabs(x) - std::fabs(y)));
}

// The surface of a point (octree/point_surface.h) in 32 bits: one for "exists", 10 + 10 for the normal, sign
// and 5 for the height, 5 for the thickness.

namespace packed_surface {

constexpr double k_side_steps = 1022.0;
/// Radians from a normal to the stored one, at most. Both numbers are rounded by at most half a step,
/// e = 1 / k_side_steps of their range [-1, 1]. So x and y on the octahedron |x| + |y| + |z| = 1 change by at
/// most e together, and z by at most e: by e sqrt(2) in all, at no less than 1 / sqrt(3) from the origin.
constexpr double k_normal_error = 2.44948974278318 / k_side_steps;
constexpr std::uint32_t k_exists = 0x80000000u, k_side_mask = 0x3ffu, k_below = 0x400u, k_length_mask = 31u;
constexpr int k_first_side = 21, k_second_side = 11, k_height = 5;  ///< the lowest bit of each

/// Lengths that five bits represent, in units of TreeView::surface_unit: 0, then from 2^-13 up to 4 by
/// factors of the root of 2. Heights are stored as the nearest one, thicknesses as the least that is not
/// smaller.
constexpr double k_greatest_length = 4.0, k_root_of_half = 0.70710678118654752;
constexpr std::array<double, 32> k_lengths = [] {
  std::array<double, 32> lengths{};
  double whole = k_greatest_length;
  for (std::size_t i = 31; i > 0; --i) {
    lengths[i] = i % 2 == 1 ? whole : k_root_of_half * whole;
    if (i % 2 == 0) whole *= 0.5;
  }
  return lengths;
}();

}  // namespace packed_surface
}  // namespace alidade
