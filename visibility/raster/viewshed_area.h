// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "base/bounds.h"
#include "visibility/observers.h"

namespace alidade {

/// The part of an area that is in reach of any observer, in x and y. Errors: none is.
Bounds area_in_reach(const Bounds& area, std::span<const Observer> observers);

/// A cell size for an area, where nobody chose one: 1, 2 or 5 times a power of ten, the smallest that gives
/// at most 1000 cells along the longer side and is not below `finest`.
double usual_resolution(const Bounds& area, double finest = 0.0);

}  // namespace alidade
