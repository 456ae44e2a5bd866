// SPDX-License-Identifier: MIT
#pragma once

#include "octree/cloud/point_cloud.h"

namespace alidade {

/// For answers that are angles: Error if x and y of the cloud are degrees and z is a length, so that nothing
/// has an elevation.
void check_map_unit(const PointCloud& cloud);

}  // namespace alidade
