// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "base/bounds.h"
#include "base/progress.h"
#include "visibility/observers.h"

namespace alidade {

/// A grid has at most so many places.
constexpr double k_most_grid_observers = 1e6;

/// Candidates for observers: the middles of square cells of this width that cover the extent and share its
/// middle, row by row from the south-west, where there is ground to stand on; named "ROW-COLUMN" from 1.
/// `progress` is in cells. Errors: `width` not above 0 and finite; more than k_most_grid_observers cells; no
/// ground anywhere.
std::vector<GivenObserver> observer_grid(const Bounds& extent, double width, const GroundHeight& ground,
                                         const Progress& progress = {});

}  // namespace alidade
