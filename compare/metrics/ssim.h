// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "compare/compared_image.h"

namespace alidade::compare {

/// How alike two images are in structure: 1 for equal images, at worst about -1.
struct Similarity {
  double ssim = std::numeric_limits<double>::quiet_NaN();
  double ms_ssim = std::numeric_limits<double>::quiet_NaN();
};

/// Of the display colours, each channel for itself, then the mean of the channels. Symmetric in the images.
///
/// SSIM: Gaussian window of deviation 1.5 and 11 x 11 pixels, K1 = 0.01, K2 = 0.03, range 1; the mean over
/// the pixels that count and whose window lies inside, NaN if there are none. Colours of pixels that do not
/// count are those of the reference in both. Source: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli,
/// "Image Quality Assessment: From Error Visibility to Structural Similarity", IEEE Trans. Image Processing
/// 13(4), 2004. Equal to scikit-image's structural_similarity with gaussian_weights and without
/// use_sample_covariance, within 1e-6.
///
/// MS-SSIM: SSIM at five scales, each half as large: contrast and structure of all, luminance of the
/// smallest, to the powers 0.0448, 0.2856, 0.3001, 0.2363 and 0.1333. Factors below 0 count as 0. A smaller
/// image has the means of 2 x 2 pixels, beyond an odd border the border again; such a pixel counts if all
/// it comes from do. NaN if a side is shorter than 161 pixels. Source: Z. Wang, E. P. Simoncelli, A. C.
/// Bovik, "Multiscale Structural Similarity for Image Quality Assessment", Asilomar 2003.
///
/// Equal bits on any number of threads. Errors: sizes differ, an image without colour. Cost on 2 cores:
/// about 0.04 s per million pixels; memory: 24 bytes for each fourth pixel.
Similarity similarity(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask = {});

}  // namespace alidade::compare
