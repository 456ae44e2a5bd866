// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include "base/instruction_set.h"
#include "octree/query.h"
#include "octree/simd/sort_keys.h"

namespace alidade::simd {

/// Makes the rays that make_ray makes, bit for bit: of the rows from first_row on, or with `order`, which is
/// as long as `rays`, of the rows first_row + number_of(order[i]). Returns whether make_ray accepts all of
/// them; if not, `rays` holds nothing of use.
bool make_rays(InstructionSet instruction_set, const RayColumns& columns, std::size_t first_row,
               std::span<const SortKey> order, std::span<Ray> rays);

}  // namespace alidade::simd
