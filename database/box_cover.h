// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "base/bounds.h"

namespace alidade::database {

/// Boxes sorted along an axis. Neighbours share at most a face, which is perpendicular to this axis.
struct BoxCover {
  int axis = 0;  ///< 0 to 2: x, y or z
  std::vector<Bounds> boxes{};
};

/// The share of a box in the volume of `bounds`, or in their area or length if they have no thickness.
double volume_share(const Bounds& box, const Bounds& bounds);

/// At most `count` boxes that contain every point of `bounds` for which a condition holds, for engines that
/// prune by the least and greatest coordinate and not by distances. `may_hold` is false only for a box
/// without such a point (database/point_filter.h). A diagonal ray gets a staircase of boxes, an axis-parallel
/// one a single box. The axis is that of the smallest cover. Requires finite bounds and a count of at least
/// 1. Cost: some 20,000 calls of `may_hold`.
BoxCover cover(const std::function<bool(const Bounds&)>& may_hold, const Bounds& bounds, std::size_t count);

}  // namespace alidade::database
