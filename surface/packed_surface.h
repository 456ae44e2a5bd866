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

// The surface of a point (surface/point_surface.h) in 32 bits: one for "exists", 10 + 10 for the normal, sign
// and 5 for the height, 5 for the thickness.

namespace packed_surface {

constexpr double k_side_steps = 1022.0;
/// Radians from a normal to the stored one, at most. Both numbers are rounded by at most half a step,
/// e = 1 / k_side_steps of their range [-1, 1]. So x and y on the octahedron |x| + |y| + |z| = 1 change by at
/// most e together, and z by at most e: by e sqrt(2) in all, at no less than 1 / sqrt(3) from the origin.
constexpr double k_normal_error = 2.44948974278318 / k_side_steps;
constexpr std::uint32_t k_exists = 0x80000000u, k_side_mask = 0x3ffu, k_below = 0x400u, k_length_mask = 31u;
constexpr int k_first_side = 21, k_second_side = 11, k_height = 5;  ///< the lowest bit of each

/// Lengths that five bits represent, in units of PointLayers::surface_unit: 0, then from 2^-13 up to 4 by
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

// The edge beside a point in 8 bits: 3 for the distance in steps, where 0 means none, 5 for the direction.

constexpr int k_edge_directions = 32, k_edge_levels = 7;
constexpr double k_edge_step = 0.1, k_edge_gap = 0.2;  ///< spacings

/// All around in even steps. Made with roots alone, which are the same on every machine.
inline const std::array<glm::dvec2, k_edge_directions>& edge_directions() {
  static const std::array<glm::dvec2, k_edge_directions> all = [] {
    std::array<glm::dvec2, k_edge_directions> made{};
    made[0] = {1.0, 0.0};
    made[k_edge_directions / 4] = {0.0, 1.0};
    for (int step = k_edge_directions / 4; step > 1; step /= 2) {
      for (int i = 0; i < k_edge_directions / 4; i += step)
        made[i + step / 2] = glm::normalize(made[i] + made[i + step]);
    }
    for (int i = k_edge_directions / 4; i < k_edge_directions; ++i) {
      const glm::dvec2& before = made[i - k_edge_directions / 4];
      made[i] = {-before.y, before.x};
    }
    return made;
  }();
  return all;
}

}  // namespace packed_surface
}  // namespace alidade
