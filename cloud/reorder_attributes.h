// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "cloud/point_cloud.h"

namespace alidade {

/// Brings the rows of all attribute columns into another order: row i becomes what row order[i] was. Columns
/// that are absent stay absent; positions are left as they are. `order` holds every row once. Memory: one
/// column at a time.
void reorder_attributes(PointCloud& cloud, std::span<const std::uint32_t> order);

}  // namespace alidade
