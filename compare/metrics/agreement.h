// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "compare/compared_image.h"

// Depths that are measured do not differ before they differ by more than their errors.

namespace alidade::compare {

/// How the depths of two images agree in a pixel.
enum class Agreement {
  nothing,      ///< neither has a depth (is_depth())
  agrees,       ///< the depths differ by no more than their errors
  not_scanned,  ///< one has a depth, and the other is a scan without points there
  differs       ///< by more than their errors, or the other, which is no scan, shows that nothing is there
};

/// Compares depths with their standard deviations, the layer depth.sigma. Of an image without the layer they
/// are 0, and so are NaN and values below 0. Depths agree if
///
///   |test - reference| <= 3 sqrt(sigma_reference^2 + sigma_test^2)
///
/// Where only one image has a depth, this depth agrees if its sigma is infinite: it may be the rim of a sheet
/// that ends beside the pixel. Otherwise the other image decides. A scan has the layer, and not 0 at all of
/// its depths; it has no points there, which is no difference. An image of exact surfaces (without the layer,
/// or 0 at all of its depths) shows that there is no surface: the images differ.
class DepthAgreement {
 public:
  /// The images must have depth, be of equal size, and outlive this. Cost: a pass over the sigmas.
  DepthAgreement(const ComparedImage& reference, const ComparedImage& test);

  Agreement at(std::size_t pixel) const;

 private:
  const ComparedImage &reference_, &test_;
  bool reference_is_scan_, test_is_scan_;
};

/// Counts of the pixels that count; the others of these see nothing in both images.
struct AgreementMetrics {
  std::uint64_t agreeing = 0, differing = 0, not_scanned = 0;
};

/// Whether both images have depth, and at least one of them its sigma.
bool have_agreement(const ComparedImage& reference, const ComparedImage& test);

/// Empty unless have_agreement(). Requires images of equal size. Equal on any number of threads.
std::optional<AgreementMetrics> agreement_metrics(const ComparedImage& reference, const ComparedImage& test,
                                                  const ImageMask& mask = {});

}  // namespace alidade::compare
