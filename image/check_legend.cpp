// SPDX-License-Identifier: MIT
#include "image/check_legend.h"

#include "base/error.h"

namespace alidade {

void check_legend(const ColorKey& key) {
  if (key.by == PointColor::rgb) {
    throw Error({.problem = "a legend has nothing to explain: the colours are the points' own",
                 .expected = "points coloured by height, intensity, classification or another attribute",
                 .found = "rgb"});
  }
  if (key.by != PointColor::normal && key.point_count == key.missing_count)
    throw Error({.problem = "a legend has nothing to explain: no point has a value of " + key.word});
}

}  // namespace alidade
