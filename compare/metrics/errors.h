// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "compare/compared_image.h"
#include "compare/metrics/agreement.h"

namespace alidade::compare {

/// Differences test - reference of all channel values of the pixels that count.
struct ErrorMetrics {
  std::uint64_t values = 0;    ///< compared: pixels times channels
  std::uint64_t excluded = 0;  ///< pixels with a NaN or infinite value, which are not compared
  double mean = 0.0;           ///< with sign
  double mean_abs = 0.0;
  double rmse = 0.0;
  double max_abs = 0.0;
  int max_x = -1, max_y = -1, max_channel = -1;  ///< where: the first in reading order; -1 if nothing differs
  double psnr = 0.0;           ///< 20 log10(1 / rmse), dB: for a peak of 1; infinite without any difference
  double percentile_95 = 0.0;  ///< smallest value that 95 % or more of the absolute differences do not exceed
};

/// `channels` values per pixel, `width` pixels per row. Requires channels >= 1, width >= 1 and two lists of
/// equal length, which is that of whole rows. Without values everything is 0 and PSNR NaN. Equal bits on any
/// number of threads. Cost on 2 cores: about 0.03 s per million pixels.
ErrorMetrics error_metrics(std::span<const float> reference, std::span<const float> test, int channels,
                           int width, const ImageMask& mask = {});

/// Errors of the colours of two images in sRGB values or in linear light, three channels (one if both are
/// grey). Where both hold whole numbers of one kind and these are compared as stored, differences are
/// those of the numbers, without a rounding. Errors: sizes differ, an image without colour.
ErrorMetrics error_metrics(const ComparedImage& reference, const ComparedImage& test, ColorEncoding encoding,
                           const ImageMask& mask = {});

/// Depth: differences test - reference, metres, of the pixels where both have one (is_depth()).
struct DepthMetrics {
  std::uint64_t pixels = 0;                         ///< with a depth in both
  std::uint64_t only_reference = 0, only_test = 0;  ///< with a depth in one: something is gone or new
  std::uint64_t invalid = 0;  ///< with NaN or a number below 0 in either, which is taken for no depth
  double mean = 0.0, mean_abs = 0.0, rmse = 0.0, max_abs = 0.0, percentile_95 = 0.0;
  int max_x = -1, max_y = -1;  ///< where: the first in reading order; -1 if nothing differs
  double mean_relative = 0.0;  ///< of |difference| / reference
  double percent_within_1_cm = 0.0, percent_within_5_cm = 0.0;  ///< |difference| <= 0.01, 0.05
  double percent_within_1_percent = 0.0;                        ///< |difference| <= 0.01 reference
};

/// Angles between normals, degrees, of the pixels where both have one; their lengths do not matter.
struct NormalMetrics {
  std::uint64_t pixels = 0, only_reference = 0, only_test = 0;
  std::uint64_t invalid = 0;  ///< with NaN or infinity in either, which is taken for no normal
  double mean = 0.0, max = 0.0, percentile_95 = 0.0;
  int max_x = -1, max_y = -1;
};

/// Ids, of the pixels where at least one image sees something.
struct IdMetrics {
  std::uint64_t pixels = 0, equal = 0;
  double percent_equal = 0.0;
};

/// Alpha, of the pixels where both are finite.
struct AlphaMetrics {
  std::uint64_t pixels = 0;
  std::uint64_t invalid = 0;  ///< the others
  double mean_abs = 0.0, max_abs = 0.0;
  int max_x = -1, max_y = -1;
};

/// Of the layers that both images have; others are empty.
struct LayerMetrics {
  std::optional<DepthMetrics> depth;
  std::optional<AgreementMetrics> agreement;  ///< of depth, if at least one has its sigma
  std::optional<NormalMetrics> normals;
  std::optional<IdMetrics> ids;
  std::optional<AlphaMetrics> alpha;
};

/// Over the pixels that count. Percentiles: nearest rank, as in ErrorMetrics. Means and percents without
/// pixels are 0. Equal bits on any number of threads. Errors: sizes differ.
LayerMetrics layer_metrics(const ComparedImage& reference, const ComparedImage& test,
                           const ImageMask& mask = {});

}  // namespace alidade::compare
