// SPDX-License-Identifier: MIT
#pragma once

#include "octree/index_file/indexed_cloud.h"

namespace alidade {

/// What a copy of a cloud with other columns says of itself: lattice, reference system, LAS records and
/// encoding. No points, no columns.
PointCloud description_of(const IndexedCloud& cloud);

}  // namespace alidade
