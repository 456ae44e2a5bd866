// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "octree/spacing.h"

namespace alidade::test {

/// The spacings by point id, metres. Requires spacings.
inline std::vector<double> spacings_by_id(const Octree& octree) {
  const HugeVector<float> spacings = spacings_in_order(octree);
  return std::vector<double>(spacings.begin(), spacings.end());
}

}  // namespace alidade::test
