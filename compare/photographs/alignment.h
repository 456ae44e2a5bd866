// SPDX-License-Identifier: MIT
#pragma once

#include "compare/compared_image.h"

// Whether the edges of two images lie on each other: distinguishes a camera that is off by some pixels from
// colours that differ.

namespace alidade::compare {

struct AlignmentOptions {
  int largest_shift = 64;  ///< pixels in x and in y, up to which a shift is searched; 1 .. 4096
};

/// Where the edges of the test lie against those of the reference.
struct Alignment {
  /// Pixels: what the reference shows at (x, y) the test shows at (x + shift_x, y + shift_y).
  double shift_x = 0.0, shift_y = 0.0;
  double score = 0.0;            ///< gradient correlation at this shift, -1 .. 1; 1: equal edges
  double score_unshifted = 0.0;  ///< gradient correlation without a shift
  /// Whether the shift can be relied on: there are enough edges, in more than one direction, they agree, and
  /// no other shift within reach scores as high. Otherwise the shift is meaningless.
  bool is_certain = false;
};

/// Finds the shift that maximises the gradient correlation: the sum over the pixels of g_r . g_t, divided by
/// sqrt(sum |g_r|^2 * sum |g_t|^2). g are gradients of the luminance (of the display-referred colours), each
/// divided by sqrt(|g|^2 + s^2), s the root mean square of |g| in its image: few strong edges, such as a
/// roof before the sky, do not outvote many weak ones, and exposure and contrast play no role. Images are
/// blurred by a binomial filter before, and only by pixels that count: in the mask, finite, with alpha of at
/// least one half, and where an image has depth, with one. So holes between points and the edge of what
/// was scanned are no edges. Pixels without a neighbour that counts take no part.
///
/// The search goes from coarse to fine over a pyramid of halved images: all shifts on the coarsest level,
/// then uphill on each finer one from the best four; sub-pixel from the parabola through the peak. Shifts
/// without an overlap of both images are not tried. Sums are of whole numbers, so they are equal on any
/// number of threads.
///
/// Both images must have colours and one size. Cost: about a second for 8 million pixels on two cores;
/// 16 bytes per pixel. Errors: images so long and narrow that so many shifts would take minutes.
/// Source: V. Argyriou, T. Vlachos, Estimation of sub-pixel motion using gradient cross-correlation,
/// Electronics Letters 39 (2003).
Alignment align(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask,
                const AlignmentOptions& options = {});

}  // namespace alidade::compare
