// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>

// Pseudo-random numbers as functions of a position or a counter. Integer hashing and
// exact double operations only.

namespace alidade::simulation {

/// A bijective hash of 64 bits: the finisher of the SplitMix64 generator (Steele, Lea, Flood 2014).
inline std::uint64_t mix_bits(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15u;
  value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
  value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
  return value ^ (value >> 31);
}

inline std::uint64_t hash_of(std::uint64_t a, std::uint64_t b) {
  return mix_bits(mix_bits(a) ^ (b * 0xd1342543de82ef95u));
}

/// [0, 1), 53 bits.
inline double unit_of(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// Number of the cell that a coordinate lies in.
inline std::uint64_t cell_of(double coordinate) {
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(coordinate)));
}

/// A number in [0, 1) for an integer cell of the plane.
inline double cell_noise(double x, double y, std::uint32_t seed) {
  return unit_of(
      mix_bits(cell_of(x) * 0x8cb92ba72f3d8dd7u ^ mix_bits(cell_of(y) + (std::uint64_t{seed} << 32))));
}

/// Smooth noise in [0, 1): random values at integer coordinates, eased between them.
inline double smooth_noise(const glm::dvec3& position, std::uint32_t seed) {
  const double x = position.x - std::floor(position.x), y = position.y - std::floor(position.y),
               z = position.z - std::floor(position.z);
  const double u = x * x * (3.0 - 2.0 * x), v = y * y * (3.0 - 2.0 * y), w = z * z * (3.0 - 2.0 * z);
  const std::uint64_t column = cell_of(position.x), row = cell_of(position.y), level = cell_of(position.z);
  const auto corner = [&](std::uint64_t dx, std::uint64_t dy, std::uint64_t dz) {
    const std::uint64_t bits =
        mix_bits((column + dx) * 0x8cb92ba72f3d8dd7u ^ (row + dy) * 0xabc98388fb8fac03u ^
                 (level + dz) * 0xd1342543de82ef95u ^ (std::uint64_t{seed} << 32));
    return static_cast<double>(bits >> 32) * 0x1p-32;
  };
  const auto across = [&](std::uint64_t dy, std::uint64_t dz) {
    const double left = corner(0, dy, dz);
    return left + u * (corner(1, dy, dz) - left);
  };
  const auto sheet = [&](std::uint64_t dz) {
    const double near = across(0, dz);
    return near + v * (across(1, dz) - near);
  };
  const double low = sheet(0);
  return low + w * (sheet(1) - low);
}

}  // namespace alidade::simulation
