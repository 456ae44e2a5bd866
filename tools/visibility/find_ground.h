// SPDX-License-Identifier: MIT
#pragma once

#include "tools/visibility/blocking_cloud.h"
#include "visibility/raster/ground.h"

namespace alidade {

/// make_ground() below a cloud, with its progress shown. Occluders need not be measured.
Ground find_ground(const VisibilityCloud& cloud, GroundOptions options, Verbosity verbosity);

}  // namespace alidade
