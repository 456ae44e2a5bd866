// SPDX-License-Identifier: MIT
#pragma once

#include "image/color_key.h"

namespace alidade {

/// Errors: a legend has nothing to explain, since the colours are the points' own, or there is no point.
void check_legend(const ColorKey& key);

}  // namespace alidade
