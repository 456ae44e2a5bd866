// SPDX-License-Identifier: MIT
#pragma once

#include "compare/compared_pair.h"

namespace alidade {

/// Both pictures as screens show them. To be called before colours are matched.
ComparisonPictures shown_pictures(const ComparedPair& pair);

/// Adds maps and histograms of what the pair has. `flip`: map of FLIP, if there are colours.
void add_maps(ComparisonPictures& pictures, const ComparedPair& pair, std::span<const float> flip);

}  // namespace alidade
