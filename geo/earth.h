// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// Radius of the sphere that stands for the Earth, metres.
constexpr double k_earth_radius = 6'371'000.0;

}  // namespace alidade
