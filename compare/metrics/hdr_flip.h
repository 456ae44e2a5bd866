// SPDX-License-Identifier: MIT
#pragma once

#include "compare/metrics/flip.h"
#include "compare/metrics/flip_model.h"

namespace alidade {

/// Most exposures that HDR-FLIP goes through.
constexpr int k_most_exposures = 256;

/// Exposures from `start` to `stop`, both ends included, in stops.
struct ExposureRange {
  double start = 0.0, stop = 0.0;
  int count = 1;

  double exposure(int i) const { return i == count - 1 ? stop : start + i * (stop - start) / (count - 1); }
};

/// The curve of a tone mapper at an exposure in stops.
ToneCurve tone_curve(ToneMapper mapper, double exposure);

/// The exposures at which the tone mapper brings the brightest and the median pixel of the reference to 0.85,
/// one per stop between them, at least 2. Source: Eurographics 2021, section 4.2.
/// The authors' tool finds no end for pictures of which half is black. Here the median is taken of the pixels
/// with light then; a picture without any light (or no pixel that counts) gives the single exposure 0.
/// Options that fix start, stop or count are obeyed. Errors: start above stop, not finite or beyond 1000
/// stops, a count below 2 or above k_most_exposures.
ExposureRange exposure_range(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask,
                             const FlipOptions& options);

}  // namespace alidade
