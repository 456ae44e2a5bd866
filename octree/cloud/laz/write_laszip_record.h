// SPDX-License-Identifier: MIT
#pragma once

#include "octree/cloud/laz/laz_layout.h"
#include "octree/cloud/point_cloud.h"

namespace alidade {

/// The variable length record "laszip encoded" 22204, which tells how points are packed.
VariableLengthRecord laszip_record(const LazLayout& layout);

}  // namespace alidade
