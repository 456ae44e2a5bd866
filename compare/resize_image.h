// SPDX-License-Identifier: MIT
#pragma once

#include "compare/compared_image.h"

namespace alidade {

/// The image at another size: colour and alpha through OpenImageIO's resize (its default filter: Lanczos 3
/// when shrinking, Blackman-Harris when growing), display colours clamped to 0 .. 1, linear ones to no less
/// than 0 or the least that the image has; NaN and infinity spread over the pixels that the filter reaches.
/// Depth, normals and ids are taken from the nearest pixel, since a mean of two depths or ids is nobody's.
/// The origin is 0, 0. The same bytes on any number of threads. Errors: a size that is not positive or beyond
/// k_most_compared_pixels, what OpenImageIO reports. Cost: about a second for 8 million pixels; memory: the
/// result.
ComparedImage resized(const ComparedImage& image, int width, int height);

}  // namespace alidade
