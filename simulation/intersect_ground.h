// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "simulation/shapes.h"

namespace alidade::shapes {

/// Largest |height| the ground can reach.
double amplitude_of(const Ground& ground);

/// intersect() for the rolling ground. Where the ray comes down over the level core the answer is the
/// plane's; elsewhere |z - height| <= 1e-12 m holds at the answer, and no earlier crossing is left out: each
/// step is as far as the bound on the ground's curvature proves to be free.
std::optional<double> intersect_ground(const Ground& ground, const Ray& ray);

}  // namespace alidade::shapes
