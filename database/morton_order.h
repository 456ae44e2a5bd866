// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "octree/cloud/lattice.h"

namespace alidade {

/// The rows of a cloud along a Morton curve; rows at one place as they were. Requires fewer than 2^32.
/// Memory at the peak: 36 bytes per row.
std::vector<std::uint32_t> morton_order(const std::vector<LatticePosition>& positions);

}  // namespace alidade
