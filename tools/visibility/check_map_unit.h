// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/point_cloud.h"

namespace alidade {

/// Error if x and y of the cloud are degrees and z is a length: then no distance can be measured and nothing
/// has an elevation, so that all answers about sight would be wrong.
void check_map_unit(const PointCloud& cloud);

}  // namespace alidade
