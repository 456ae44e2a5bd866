// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "renderer/scene.h"

namespace alidade {

/// Where the pixels of a picture from straight above lie: world x = [0] + [1] column + [2] row, y = [3] + [4]
/// column + [5] row, with (0, 0) the outer corner of the first pixel. Errors: the camera's rays are not
/// parallel, or do not point straight down.
std::array<double, 6> ground_transform(const Camera& camera);

}  // namespace alidade
