// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "compare/metrics/flip.h"

namespace alidade::compare {

/// Half of a filter's taps: that of the centre, then those of pixels 1, 2, ... away. The other half is the
/// same or, for the first derivative, has the opposite sign.
using HalfTaps = std::vector<float>;

/// The filters of FLIP for one viewing distance. Source: P. Andersson, J. Nilsson, T. Akenine-Möller, M.
/// Oskarsson, K. Åström, M. Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG 2020,
/// sections 4.1.1 and 4.2, with the normalisation of its authors' tool, version 1.6.
struct FlipFilters {
  // Contrast sensitivity of the eye, of sum 1. Blue-yellow is the sum of two, of equal reach, each in x and
  // y.
  HalfTaps achromatic, red_green, blue_yellow, blue_yellow_wide;
  // Features: a Gaussian of sum 1 and its derivatives, whose positive and negative taps add up to 1 and -1;
  // all three of equal reach.
  HalfTaps smooth, edge, point;
  /// How far the widest reaches, in pixels.
  int radius = 0;
};

/// `pixels_per_degree` of the eye's field of view: 1 to 1000.
/// Errors: outside that.
FlipFilters flip_filters(double pixels_per_degree);

/// The colour spaces of FLIP. Source: as FlipFilters; matrices of sRGB's primaries and D65 as the tool has
/// them. CIE XYZ is relative to the white point (1, 1, 1), and the opponent space YCxCz without its
/// constant and factors (y = (Y + 16) / 116, x - y = Cx / 500, y - z = Cz / 200), which filters of sum 1 do
/// not see.
struct FlipColor {
  float xyz_from_rgb[3][3];  ///< rows x y z: each adds up to 1, so that grey stays grey
  float rgb_from_xyz[3][3];
  float largest_difference;  ///< between green and blue, to the power 0.7
};

const FlipColor& flip_color();

/// How linear light is mapped before FLIP: times `scale`, then through the curve
/// (k0 x^2 + k1 x + k2) / (k3 x^2 + k4 x + k5), or divided by 1 + the pixel's luminance, or as it is; then
/// clamped to 0 .. 1.
struct ToneCurve {
  enum class Kind { none, rational, luminance };
  Kind kind = Kind::none;
  float scale = 1.0f;
  float k[6] = {};
};

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
/// The authors' tool finds no end for images that are half black. Here the median is then that of the
/// pixels with light; an image without any light (or no pixel that counts) gives the single exposure 0.
/// Options that fix start, stop or count are obeyed. Errors: start above stop, not finite or beyond 1000
/// stops, a count below 2 or above k_most_exposures.
ExposureRange exposure_range(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask,
                             const FlipOptions& options);

}  // namespace alidade::compare
