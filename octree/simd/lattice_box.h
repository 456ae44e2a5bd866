// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/bounds.h"
#include "octree/octree.h"

namespace alidade::simd {

/// The lattice steps whose world coordinates lie in a box, counted from the root's corner, both ends
/// inclusive. Exactly those: to_world() never falls when steps grow, so the ends can be found by calling it.
struct LatticeBox {
  std::int64_t low[3], high[3];

  LatticeBox(const TreeView& tree, const Bounds& box) {
    for (int axis = 0; axis < 3; ++axis) {
      // First steps at or above the lower face, and first steps above the upper one.
      low[axis] = first_step(tree, axis, box.min[axis], false) - tree.base[axis];
      high[axis] = first_step(tree, axis, box.max[axis], true) - 1 - tree.base[axis];
    }
  }

  bool empty() const { return low[0] > high[0] || low[1] > high[1] || low[2] > high[2]; }

  bool contains(const LatticePosition& position, const LatticePosition& base) const {
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t step = std::int64_t{position[axis]} - base[axis];
      if (step < low[axis] || step > high[axis]) return false;
    }
    return true;
  }

 private:
  static constexpr std::int64_t k_before = -(std::int64_t{1} << 31), k_behind = std::int64_t{1} << 31;

  /// The first lattice step at or above a coordinate (above it, if `above`); k_behind if there is none.
  static std::int64_t first_step(const TreeView& tree, int axis, double coordinate, bool above) {
    const auto stands_before = [&](std::int64_t step) {
      LatticePosition position(0);
      position[axis] = static_cast<std::int32_t>(step);
      const double there = to_world(tree.lattice, position)[axis];
      return above ? there <= coordinate : there < coordinate;
    };
    // Rounding moves the end by few steps, unless steps are finer than doubles.
    const double guess = (coordinate - tree.lattice.offset[axis]) / tree.lattice.scale[axis];
    const auto near = static_cast<std::int64_t>(std::clamp(
        std::isnan(guess) ? 0.0 : guess, static_cast<double>(k_before), static_cast<double>(k_behind)));
    std::int64_t low = std::max(near - 4, k_before), high = std::min(near + 4, k_behind);
    if (low > k_before && !stands_before(low - 1)) low = k_before;
    if (high < k_behind && stands_before(high)) high = k_behind;
    while (low < high) {
      const std::int64_t middle = low + (high - low) / 2;
      if (stands_before(middle)) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }
};

}  // namespace alidade::simd
