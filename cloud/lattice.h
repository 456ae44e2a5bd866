// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

namespace alidade {

/// A point as the cloud stores it: three 32-bit steps on the lattice.
using LatticePosition = glm::ivec3;

/// The grid all points of a cloud stand on, exactly as in LAS: world = offset + scale * steps.
/// `scale` is positive on every axis, in the unit of the CRS (metres unless the file says otherwise).
struct Lattice {
  glm::dvec3 scale{0.001};
  glm::dvec3 offset{0.0};

  bool operator==(const Lattice&) const = default;
};

/// Lattice steps -> world. The only place where this is computed: every part of Alidade (brute force, index,
/// writers) sees the same double for the same point. Two roundings per axis, never fused.
inline glm::dvec3 to_world(const Lattice& lattice, const LatticePosition& position) {
  return {lattice.offset.x + lattice.scale.x * position.x, lattice.offset.y + lattice.scale.y * position.y,
          lattice.offset.z + lattice.scale.z * position.z};
}

/// World -> nearest lattice steps; empty if a coordinate is not finite or does not fit into 32 bits.
inline std::optional<LatticePosition> to_lattice(const Lattice& lattice, const glm::dvec3& world) {
  LatticePosition position;
  for (int axis = 0; axis < 3; ++axis) {
    const double steps = std::nearbyint((world[axis] - lattice.offset[axis]) / lattice.scale[axis]);
    if (!(steps >= -2147483648.0 && steps <= 2147483647.0)) return std::nullopt;
    position[axis] = static_cast<std::int32_t>(steps);
  }
  return position;
}

/// Low and high corner of points in lattice positions; low is above high while there are none.
struct LatticeExtent {
  LatticePosition low{2147483647}, high{-2147483647 - 1};

  void grow(const LatticePosition& p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  void grow(const LatticeExtent& other) {
    grow(other.low);
    grow(other.high);
  }
};

}  // namespace alidade
