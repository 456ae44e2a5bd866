// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace alidade {

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

}  // namespace alidade
