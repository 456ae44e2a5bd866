// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <random>

#include "cloud/point_cloud.h"

namespace alidade::bench {

/// Coordinates of uniform points are multiples of this, so that float and lattice hold them exactly.
constexpr double k_uniform_step = 0x1p-17;

/// Random points of the unit cube, in random order; the same on every run.
inline PointCloud uniform_cloud(std::size_t point_count) {
  std::mt19937_64 random(5);
  PointCloud cloud;
  cloud.lattice.scale = glm::dvec3(k_uniform_step);
  cloud.positions.resize(point_count);
  for (LatticePosition& position : cloud.positions) {
    const std::uint64_t bits = random();
    position = {bits & 0x1ffff, bits >> 17 & 0x1ffff, bits >> 34 & 0x1ffff};
  }
  return cloud;
}

/// A random position in the unit cube, a float on each axis.
inline glm::dvec3 uniform_position(std::mt19937_64& random) {
  const auto coordinate = [&] { return static_cast<double>(random() >> 40) * 0x1p-24; };
  const double x = coordinate(), y = coordinate(), z = coordinate();
  return {x, y, z};
}

}  // namespace alidade::bench
