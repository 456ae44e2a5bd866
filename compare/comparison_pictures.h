// SPDX-License-Identifier: MIT
#pragma once

#include "compare/compared_pair.h"

namespace alidade {

/// Both pictures as screens show them. To be called before colours are matched.
ComparisonPictures shown_pictures(const ComparedPair& pair);

/// Maps of a pair that were made for something else, or are still to be made.
struct PairMaps {
  std::optional<DifferenceMap> color, depth;
};

/// Adds maps and histograms of what the pair has; those of `made` are taken. `flip`: map of FLIP, if there
/// are colours. If the test has matched colours (pictures.matched), titles say so.
void add_maps(ComparisonPictures& pictures, const ComparedPair& pair, PairMaps made, std::vector<float> flip);

}  // namespace alidade
