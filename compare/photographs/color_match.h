// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>

#include "compare/compared_image.h"

namespace alidade::compare {

struct FitPair {
  double x = 0.0, y = 0.0;
};

enum class LineKind { through_zero, free };

/// y = scale * x + offset.
struct RobustLine {
  double scale = 1.0, offset = 0.0;
  double inliers = 0.0;  ///< share of the pairs within 2.5 robust standard deviations, 0 .. 1
};

/// The line that does best for the better half of the pairs: least trimmed squares of the residuals
/// (y - scale x - offset) / (|y| + m), m the median of |y|, since errors of light grow with it. 64 starts
/// through one or two pairs chosen by a fixed seed, two concentration steps each (fit the half with the least
/// residuals), the best eight until nothing changes; then least squares over all pairs within 2.5 standard
/// deviations, estimated from the median residual. With 40 % of wrong pairs the chance that no start is free
/// of them is below 1e-12. Empty if there are fewer than 4 pairs, or if x is 0 everywhere (free: of one
/// value) in the half that fits best. Equal pairs in equal order give an equal line. Cost: some microseconds
/// per pair. Source: P. J. Rousseeuw, K. Van Driessen, Computing LTS Regression for Large Data Sets, Data
/// Mining and Knowledge Discovery 12 (2006).
std::optional<RobustLine> fit_robust_line(std::span<const FitPair> pairs, LineKind kind);

// A photograph has another exposure and another white balance than a render. The differences that are left
// when both are fitted are those of the scene, not of the camera.

enum class ColorModel {
  exposure,  ///< a factor per channel: exposure and white balance
  affine,    ///< a factor and an offset per channel: haze, flare and black level too
};

/// The fitted change of the test's colours, in linear light: matched = scale * test + offset.
struct ColorMatch {
  glm::dvec3 scale{1.0}, offset{0.0};
  double inliers = 0.0;  ///< share of the blocks that follow the fit, the least of the three channels, 0 .. 1
};

/// Fits the test to the reference, per channel, by least trimmed squares: the half of the blocks that can be
/// fitted best decides, so that up to half of the image may show something else. Blocks are squares of
/// pixels, about 64 of them along the longer side of the image; a block's value is the mean, in linear
/// light, of those of its pixels that count: in the mask, finite, opaque, and in display-encoded images not
/// at the ends of the codes, where cameras clip. Means of blocks have little noise and bear a few pixels of
/// misalignment. The fit is then repeated once over all blocks within 2.5 robust standard deviations, which
/// are the inliers.
/// Empty if fewer than 16 blocks are left, or if a channel does not vary enough (black; for affine:
/// of one value). Both images must have colours and one size. Cost: one pass over the pixels, then some
/// milliseconds per channel. Equal results on any number of threads. Source: P. J. Rousseeuw, K. Van
/// Driessen, Computing LTS Regression for Large Data Sets, Data Mining and Knowledge Discovery 12 (2006):
/// random starts, concentration steps, reweighted least squares.
std::optional<ColorMatch> match_color(const ComparedImage& reference, const ComparedImage& test,
                                      const ImageMask& mask, ColorModel model);

/// Replaces the colours of an image by the matched ones, in its own encoding: display-encoded images are
/// cut off at 0 and 1, linear ones are not.
void apply_color_match(ComparedImage& image, const ColorMatch& match);

}  // namespace alidade::compare
