// SPDX-License-Identifier: MIT
#pragma once

#include "cloud/laz/laz_layout.h"
#include "cloud/point_cloud.h"

namespace alidade {

/// The variable length record "laszip encoded" 22204, which tells how points are packed.
VariableLengthRecord laszip_record(const LazLayout& layout);

}  // namespace alidade
