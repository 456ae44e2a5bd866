// SPDX-License-Identifier: MIT
#pragma once

#include "compare/compared_image.h"

namespace alidade {

/// The image at another size: colour and alpha through OpenImageIO's resize (its default filter: Lanczos 3
/// when shrinking, Blackman-Harris when growing), display colours clamped to 0 .. 1; depth, normals and ids
/// are taken from the nearest pixel, since a mean of two depths or ids is nobody's. The same bytes on any
/// number of threads. Errors: a size that is not positive or beyond k_most_compared_pixels, what OpenImageIO
/// reports.
ComparedImage resized(const ComparedImage& image, int width, int height);

}  // namespace alidade
