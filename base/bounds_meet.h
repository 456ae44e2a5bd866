// SPDX-License-Identifier: MIT
#pragma once

#include "base/bounds.h"

namespace alidade {

/// Whether two boxes have a place in common, faces included. False if one is empty or a face is not a number.
inline bool meet(const Bounds& a, const Bounds& b) {
  return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
         a.min.z <= b.max.z && b.min.z <= a.max.z;
}

}  // namespace alidade
