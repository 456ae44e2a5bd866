// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "cloud/lattice.h"

namespace alidade {

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
