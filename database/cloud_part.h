// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade {

/// Some points of a cloud in a database.
struct CloudPart {
  PointCloud cloud;                ///< by their ids
  std::vector<std::uint64_t> ids;  ///< of each row, the number it has in the whole cloud
  AttributeSet attributes{};       ///< of the whole cloud
  std::uint64_t chunks_read = 0, chunk_count = 0;
};

}  // namespace alidade
