// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "compare/compared_image.h"
#include "compare/image_mask.h"

namespace alidade {

/// How alike two pictures are, pixel by pixel and on the whole.
struct SimilarityMap {
  double mean = 0.0;       ///< NaN if there is nothing to take it of
  std::vector<float> map;  ///< one per pixel, the mean of its channels; empty for MS-SSIM
};

/// Structural similarity of the display colours: 1 for equal pictures, below 0 at worst about -1. Gaussian
/// window of deviation 1.5 and 11 x 11 pixels, K1 = 0.01, K2 = 0.03, range 1, each channel for itself.
/// Borders of the map: the picture continues as its mirror image; the mean is over the pixels whose window
/// lies inside and that count, NaN for pictures of less than 11 x 11. Colours of pixels that do not count are
/// those of the reference in both. Symmetric in the pictures. The same bits on any number of threads. Source:
/// Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image Quality Assessment: From Error Visibility to
/// Structural Similarity", IEEE Trans. Image Processing 13(4), 2004. Equal to scikit-image's
/// structural_similarity with gaussian_weights and without use_sample_covariance, within 1e-6. Errors: sizes
/// differ, a picture without colour. Cost on 2 cores: about 0.03 s per million pixels.
SimilarityMap ssim(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask = {});

/// The same at five scales, each half as large: contrast and structure of all, luminance of the smallest, to
/// the powers 0.0448, 0.2856, 0.3001, 0.2363 and 0.1333; the mean of the channels. Factors below 0 count as
/// 0. A smaller picture has the means of 2 x 2 pixels, beyond an odd border the border again; such a pixel
/// counts if all it comes from do. NaN if a side is shorter than 161 pixels. Without a map. Source: Z. Wang,
/// E. P. Simoncelli, A. C. Bovik, "Multiscale Structural Similarity for Image Quality Assessment", Asilomar
/// 2003. Memory: 24 bytes for each fourth pixel.
SimilarityMap ms_ssim(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask = {});

}  // namespace alidade
