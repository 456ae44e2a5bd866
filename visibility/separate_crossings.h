// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "visibility/sight_line.h"

// Sight through things that are not solid: OccluderOptions::transparency above 1.

namespace alidade::visibility {

/// The k-th separate crossing of each line with points, k being the transparency; empty: seen.
/// Requires: as many blockers as lines. Cost: two to three times that of the first crossings.
void find_separate_blockers(const Occluders& occluders, const ChordLines& lines,
                            std::span<std::optional<Blocker>> blockers);

}  // namespace alidade::visibility
