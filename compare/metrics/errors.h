// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "compare/compared_image.h"
#include "compare/image_mask.h"

namespace alidade {

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

/// Ids, of the pixels where at least one picture sees something.
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

/// Of the layers that both pictures have; others are empty.
struct LayerMetrics {
  std::optional<DepthMetrics> depth;
  std::optional<NormalMetrics> normals;
  std::optional<IdMetrics> ids;
  std::optional<AlphaMetrics> alpha;
};

/// Over the pixels that count. Percentiles: nearest rank, as in ErrorMetrics. Means and percents without
/// pixels are 0. The same bits on any number of threads. Errors: sizes differ.
LayerMetrics layer_metrics(const ComparedImage& reference, const ComparedImage& test,
                           const ImageMask& mask = {});

}  // namespace alidade
