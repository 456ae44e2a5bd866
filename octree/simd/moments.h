// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "base/instruction_set.h"
#include "octree/octree.h"

namespace alidade::simd {

/// Sums over the points around a position. Offsets p from it are in units of the reach; the weight of a point
/// is (1 - |p|^2)^2, and 0 beyond the reach.
struct Moments {
  float weight = 0.0f;
  float count = 0.0f;  ///< of points within reach
  std::array<float, 3> first{};
  std::array<float, 6> second{};  ///< xx xy xz yy yz zz
};

/// Sums of powers of heights over the same points with the same weights. The height of a point is its offset
/// along a direction, less a level, in units of the reach.
struct HeightSums {
  float weight = 0.0f;
  std::array<float, 4> powers{};  ///< of h, h^2, h^3, h^4
};

/// The sums, compiled for one instruction set. Unlike in queries, floats are the answer; so all sets add the
/// same numbers in the same order, in sixteen columns however many lanes there are, and no product is fused
/// with a sum.
struct MomentSums {
  Moments (*around)(const TreeView& tree, const glm::dvec3& index, double reach);
  /// direction: of length 1; level: in units of the reach.
  HeightSums (*heights)(const TreeView& tree, const glm::dvec3& index, double reach,
                        const glm::vec3& direction, float level);
};

/// For an available instruction set (not `best`).
const MomentSums& moment_sums(InstructionSet instruction_set);

}  // namespace alidade::simd
