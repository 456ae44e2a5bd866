// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "cloud/laz/layer.h"
#include "cloud/laz/laz_layers.h"
#include "cloud/laz/laz_layout.h"

namespace alidade {

/// All layers of a chunk but the first, PositionLayer, in their order; null where a layer is not wanted.
/// Errors: as count_layers().
std::vector<std::unique_ptr<Layer>> make_layers(const LazLayout& layout, const LazLayers& wanted);

}  // namespace alidade
