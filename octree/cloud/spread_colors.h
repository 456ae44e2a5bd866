// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "octree/cloud/point_cloud.h"
#include "octree/cloud/read_cloud.h"

namespace alidade {

/// The rows [first, end) that one LAS file with colours gave to a cloud.
struct ColoredRows {
  std::string file_name;
  std::size_t first = 0, end = 0;
};

/// Brings the colours of all LAS files of a cloud from the depth they use to the full 16 bits (8-bit values
/// times 257), and near infrared with them if it is no deeper. The depth is one for all: the tiles of a
/// survey come from one camera, and a dark tile of a deep survey shows no value above 255 either. What was
/// done, and which files look as if they were of the other depth, is added to the warnings. Cost: a pass over
/// the rows, a second one if they are spread.
void spread_colors(PointCloud& cloud, std::span<const ColoredRows> files, ColorDepth depth);

}  // namespace alidade
