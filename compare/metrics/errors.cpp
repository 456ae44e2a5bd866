// SPDX-License-Identifier: MIT
#include "compare/metrics/errors.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "base/exact_math.h"
#include "compare/metrics/row_sums.h"

namespace alidade {
namespace {

struct LayerSums {
  DifferenceSums<double> differences;
  std::uint64_t only_reference = 0, only_test = 0, invalid = 0;

  void add(const LayerSums& later) {
    differences.add(later.differences);
    only_reference += later.only_reference;
    only_test += later.only_test;
    invalid += later.invalid;
  }

  /// Whether both have a value; counts what one has alone.
  bool both(bool in_reference, bool in_test) {
    if (in_reference && !in_test) ++only_reference;
    if (in_test && !in_reference) ++only_test;
    return in_reference && in_test;
  }

  double percent(std::uint64_t count) const { return differences.mean(100.0 * static_cast<double>(count)); }
};

/// Calls work(pixel, sums of its row) for the pixels that count.
template <class Sums, class Work>
Sums sum_counted(const ComparedImage& image, const ImageMask& mask, const Work& work) {
  const auto width = static_cast<std::size_t>(image.width);
  return sum_rows<Sums>(static_cast<std::size_t>(image.height), [&](std::size_t y, Sums& sums) {
    for (std::size_t pixel = y * width; pixel < (y + 1) * width; ++pixel)
      if (mask.at(pixel)) work(pixel, sums);
  });
}

/// What all metrics of differences have; `Metrics` has more.
template <class Metrics>
Metrics begin_metrics(const LayerSums& sums, int width) {
  Metrics metrics;
  metrics.pixels = sums.differences.values;
  metrics.invalid = sums.invalid;
  if constexpr (requires { metrics.only_reference; }) {
    metrics.only_reference = sums.only_reference;
    metrics.only_test = sums.only_test;
  }
  if (sums.differences.most > 0.0) {
    metrics.max_x = static_cast<int>(sums.differences.most_at % static_cast<std::size_t>(width));
    metrics.max_y = static_cast<int>(sums.differences.most_at / static_cast<std::size_t>(width));
  }
  return metrics;
}

struct DepthSums : LayerSums {
  double sum_relative = 0.0;
  std::uint64_t within_1_cm = 0, within_5_cm = 0, within_1_percent = 0;

  void add(const DepthSums& later) {
    LayerSums::add(later);
    sum_relative += later.sum_relative;
    within_1_cm += later.within_1_cm;
    within_5_cm += later.within_5_cm;
    within_1_percent += later.within_1_percent;
  }
};

bool is_invalid(float depth) {
  return std::isnan(depth) || depth < 0.0f;
}

DepthMetrics compare_depth(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  const auto difference = [&](std::size_t pixel) {
    return static_cast<double>(test.depth[pixel]) - static_cast<double>(reference.depth[pixel]);
  };
  const auto sums = sum_counted<DepthSums>(reference, mask, [&](std::size_t pixel, DepthSums& row) {
    const float from = reference.depth[pixel], to = test.depth[pixel];
    if (is_invalid(from) || is_invalid(to)) ++row.invalid;
    if (!row.both(is_depth(from), is_depth(to))) return;
    const double apart = difference(pixel), size = std::fabs(apart), depth = from;
    row.differences.add(apart, pixel);
    row.sum_relative += size / depth;
    row.within_1_cm += size <= 0.01 ? 1 : 0;
    row.within_5_cm += size <= 0.05 ? 1 : 0;
    row.within_1_percent += size <= 0.01 * depth ? 1 : 0;
  });
  const DifferenceSums<double>& all = sums.differences;
  auto metrics = begin_metrics<DepthMetrics>(sums, reference.width);
  metrics.mean = all.mean(all.sum);
  metrics.mean_abs = all.mean(all.sum_abs);
  metrics.rmse = std::sqrt(all.mean(all.sum_squares));
  metrics.max_abs = all.most;
  metrics.mean_relative = all.mean(sums.sum_relative);
  metrics.percent_within_1_cm = sums.percent(sums.within_1_cm);
  metrics.percent_within_5_cm = sums.percent(sums.within_5_cm);
  metrics.percent_within_1_percent = sums.percent(sums.within_1_percent);
  const auto value_at = [&](std::size_t pixel) {
    if (!mask.at(pixel) || !is_depth(reference.depth[pixel]) || !is_depth(test.depth[pixel])) return -1.0f;
    return std::fabs(static_cast<float>(difference(pixel)));
  };
  metrics.percentile_95 = percentile_95(reference.pixels(), value_at, all.values);
  return metrics;
}

bool is_finite(const float* normal) {
  return std::isfinite(normal[0]) && std::isfinite(normal[1]) && std::isfinite(normal[2]);
}

bool is_normal(const float* normal) {
  return is_finite(normal) && (normal[0] != 0.0f || normal[1] != 0.0f || normal[2] != 0.0f);
}

/// Degrees between two vectors: from sine and cosine, which keeps small angles exact.
double angle_between(const float* one, const float* other) {
  const double ax = one[0], ay = one[1], az = one[2], bx = other[0], by = other[1], bz = other[2];
  const double x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
  return angle_of(std::sqrt(x * x + y * y + z * z), ax * bx + ay * by + az * bz) * (180.0 / std::numbers::pi);
}

NormalMetrics compare_normals(const ComparedImage& reference, const ComparedImage& test,
                              const ImageMask& mask) {
  // Angles are dear: they are kept for the percentile, which looks at them twice.
  std::vector<float> angles(reference.pixels(), -1.0f);
  const auto sums = sum_counted<LayerSums>(reference, mask, [&](std::size_t pixel, LayerSums& row) {
    const float *const from = reference.normals.data() + 3 * pixel, *const to =
                                                                        test.normals.data() + 3 * pixel;
    if (!is_finite(from) || !is_finite(to)) ++row.invalid;
    if (!row.both(is_normal(from), is_normal(to))) return;
    const double angle = angle_between(from, to);
    row.differences.add(angle, pixel);
    angles[pixel] = static_cast<float>(angle);
  });
  auto metrics = begin_metrics<NormalMetrics>(sums, reference.width);
  metrics.mean = sums.differences.mean(sums.differences.sum);
  metrics.max = sums.differences.most;
  metrics.percentile_95 = percentile_95(
      angles.size(), [&](std::size_t pixel) { return angles[pixel]; }, metrics.pixels);
  return metrics;
}

struct IdSums {
  std::uint64_t pixels = 0, equal = 0;
  void add(const IdSums& later) {
    pixels += later.pixels;
    equal += later.equal;
  }
};

IdMetrics compare_ids(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  const auto sums = sum_counted<IdSums>(reference, mask, [&](std::size_t pixel, IdSums& row) {
    if (reference.ids[pixel] == 0 && test.ids[pixel] == 0) return;
    ++row.pixels;
    row.equal += reference.ids[pixel] == test.ids[pixel] ? 1 : 0;
  });
  IdMetrics metrics{.pixels = sums.pixels, .equal = sums.equal};
  if (sums.pixels > 0)
    metrics.percent_equal = 100.0 * static_cast<double>(sums.equal) / static_cast<double>(sums.pixels);
  return metrics;
}

AlphaMetrics compare_alpha(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  const auto sums = sum_counted<LayerSums>(reference, mask, [&](std::size_t pixel, LayerSums& row) {
    const float from = reference.alpha[pixel], to = test.alpha[pixel];
    if (std::isfinite(from) && std::isfinite(to))
      row.differences.add(static_cast<double>(to) - static_cast<double>(from), pixel);
    else
      ++row.invalid;
  });
  auto metrics = begin_metrics<AlphaMetrics>(sums, reference.width);
  metrics.mean_abs = sums.differences.mean(sums.differences.sum_abs);
  metrics.max_abs = sums.differences.most;
  return metrics;
}

}  // namespace

LayerMetrics layer_metrics(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  require_same_size(reference, test);
  LayerMetrics metrics;
  if (!reference.depth.empty() && !test.depth.empty()) metrics.depth = compare_depth(reference, test, mask);
  if (!reference.normals.empty() && !test.normals.empty())
    metrics.normals = compare_normals(reference, test, mask);
  if (!reference.ids.empty() && !test.ids.empty()) metrics.ids = compare_ids(reference, test, mask);
  if (!reference.alpha.empty() && !test.alpha.empty()) metrics.alpha = compare_alpha(reference, test, mask);
  return metrics;
}

}  // namespace alidade
