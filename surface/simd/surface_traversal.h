// SPDX-License-Identifier: MIT
#pragma once

#include "base/instruction_set.h"
#include "octree/simd/traversal.h"
#include "surface/surface_cloud.h"

namespace alidade::simd {

using SurfaceTraversal = RayTraversal<SurfaceView, SurfaceQuery, SurfaceHit>;

/// The traversal for an available instruction set (not `best`).
const SurfaceTraversal& surface_traversal(InstructionSet instruction_set);

}  // namespace alidade::simd
