// SPDX-License-Identifier: MIT
#pragma once

#include "compare/compared_image.h"
#include "image/encoded_picture.h"

namespace alidade {

/// A picture as a screen shows it: its colours in sRGB, cut off at black and white. Without colours its
/// normals (x, y, z from -1 .. 1 as red, green, blue), else its depth (white at 0, black at `farthest` and
/// beyond), else its ids (every point has a colour of its own). NaN is black.
BytePicture displayed(const ComparedImage& image, double farthest);

/// The largest finite depth; 0 without any.
double farthest_depth(const ComparedImage& image);

}  // namespace alidade
