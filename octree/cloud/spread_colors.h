// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

#include "octree/cloud/point_cloud.h"
#include "octree/cloud/read_cloud.h"

namespace alidade {

/// Brings the colours of one LAS file, the rows from `first_row` on, from the depth the file uses to the full
/// 16 bits (8-bit values times 257), and near infrared with them if it is no deeper. What was done is added
/// to the warnings under `file_name`.
void spread_colors(PointCloud& cloud, std::size_t first_row, ColorDepth depth, const std::string& file_name);

}  // namespace alidade
