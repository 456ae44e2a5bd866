// SPDX-License-Identifier: MIT
#pragma once

#include "compare/compared_image.h"

namespace alidade {

/// Turns all layers as the EXIF field Orientation asks for (1 to 8; others are taken as 1, upright).
/// Source: CIPA DC-008 (Exif 2.32), 4.6.5.1, tag 274: which side of the picture row 0 and column 0 are.
void turn_upright(ComparedImage& image, int orientation);

}  // namespace alidade
