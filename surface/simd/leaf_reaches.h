// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "base/instruction_set.h"
#include "surface/surface_cloud.h"

namespace alidade::simd {

/// Writes the reaches of the points in the leaves of a node, as SurfaceView::slot_reaches has them; 0 for
/// other slots. They are too large by at most 1 % of the points' spacings.
using LeafReaches = void (*)(const SurfaceView& view, const Node& node, std::uint16_t* reaches);

/// For an available instruction set (not `best`).
LeafReaches leaf_reaches(InstructionSet instruction_set);

}  // namespace alidade::simd
