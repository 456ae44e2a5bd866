// SPDX-License-Identifier: MIT
#include "compare/metrics/errors.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "base/exact_math.h"
#include "compare/metrics/pixel_sums.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

/// Sums of one row.
template <class Number>
struct RowErrors {
  DifferenceSums<Number> differences;
  std::uint64_t excluded = 0;

  void add(const RowErrors& later) {
    differences.add(later.differences);
    excluded += later.excluded;
  }
};

/// Metrics of the differences that difference(i) returns: the test's value less the reference's, as Number.
template <class Number, class Difference>
struct Errors {
  const Difference& difference;
  std::size_t channels, width, pixels;
  const ImageMask& mask;

  /// `unit`: what a difference of 1 means.
  ErrorMetrics measure(double unit) const {
    const auto all = sum_rows<RowErrors<Number>>(
        pixels / width, [&](std::size_t y, RowErrors<Number>& sums) { add_row(y, sums); });
    return metrics(all, unit);
  }

  static bool is_finite(Number number) {
    // Whole numbers are always finite.
    if constexpr (std::is_floating_point_v<Number>) return std::isfinite(number);
    return true;
  }

  bool is_finite_pixel(std::size_t pixel) const {
    for (std::size_t i = 0; i < channels; ++i)
      if (!is_finite(difference(channels * pixel + i))) return false;
    return true;
  }

  void add_row(std::size_t y, RowErrors<Number>& sums) const {
    for (std::size_t pixel = y * width; pixel < (y + 1) * width; ++pixel) {
      if (!mask.at(pixel)) continue;
      DifferenceSums<Number> of_pixel;
      for (std::size_t i = channels * pixel; i < channels * (pixel + 1); ++i) of_pixel.add(difference(i), i);
      // A NaN makes the whole sum NaN.
      if (is_finite(of_pixel.sum_abs))
        sums.differences.add(of_pixel);
      else
        ++sums.excluded;
    }
  }

  ErrorMetrics metrics(const RowErrors<Number>& all, double unit) const {
    const DifferenceSums<Number>& sums = all.differences;
    ErrorMetrics metrics{.values = sums.values, .excluded = all.excluded};
    metrics.psnr = std::numeric_limits<double>::quiet_NaN();
    if (sums.values == 0) return metrics;
    metrics.mean = sums.mean(sums.sum) * unit;
    metrics.mean_abs = sums.mean(sums.sum_abs) * unit;
    metrics.rmse = std::sqrt(sums.mean(sums.sum_squares)) * unit;
    metrics.psnr = metrics.rmse > 0.0
                       ? -20.0 * binary_logarithm(metrics.rmse) / (std::numbers::log2e * std::numbers::ln10)
                       : std::numeric_limits<double>::infinity();
    if (sums.most > 0) {
      metrics.max_abs = static_cast<double>(sums.most) * unit;
      const std::size_t pixel = sums.most_at / channels;
      metrics.max_x = static_cast<int>(pixel % width);
      metrics.max_y = static_cast<int>(pixel / width);
      metrics.max_channel = static_cast<int>(sums.most_at % channels);
    }
    const bool do_all_count = mask.counts.empty() && all.excluded == 0;
    const auto value_at = [&](std::size_t i) {
      if (!do_all_count) {
        const std::size_t pixel = i / channels;
        if (!mask.at(pixel) || (all.excluded > 0 && !is_finite_pixel(pixel))) return -1.0f;
      }
      return std::fabs(static_cast<float>(difference(i)));
    };
    metrics.percentile_95 = percentile_95(pixels * channels, value_at, sums.values) * unit;
    return metrics;
  }
};

template <class Number, class Difference>
ErrorMetrics measure(const Difference& difference, double unit, int channels, int width, std::size_t pixels,
                     const ImageMask& mask) {
  return Errors<Number, Difference>{difference, static_cast<std::size_t>(channels),
                                    static_cast<std::size_t>(width), pixels, mask}
      .measure(unit);
}

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

/// Fills the members that all metrics of differences have.
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
  // Angles are expensive: they are kept for the percentile, which reads them twice.
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

ErrorMetrics error_metrics(std::span<const float> reference, std::span<const float> test, int channels,
                           int width, const ImageMask& mask) {
  assert(channels >= 1 && width >= 1 && reference.size() == test.size() &&
         reference.size() % (static_cast<std::size_t>(channels) * static_cast<std::size_t>(width)) == 0);
  const auto difference = [&](std::size_t i) {
    return static_cast<double>(test[i]) - static_cast<double>(reference[i]);
  };
  return measure<double>(difference, 1.0, channels, width,
                         reference.size() / static_cast<std::size_t>(channels), mask);
}

ErrorMetrics error_metrics(const ComparedImage& reference, const ComparedImage& test, ColorEncoding encoding,
                           const ImageMask& mask) {
  require_colors(reference, test, "missing colours");
  const int channels = reference.color_channels == 1 && test.color_channels == 1 ? 1 : 3;
  // Colours are stored three per pixel, in grey images three equal ones.
  const std::size_t step = channels == 1 ? 3 : 1;
  const float* const from = reference.color.data();
  const float* const to = test.color.data();
  const bool are_codes = encoding == ColorEncoding::display && reference.encoding == encoding &&
                         test.encoding == encoding && reference.largest_code > 0 &&
                         reference.largest_code == test.largest_code;
  if (are_codes) {
    const auto largest = static_cast<float>(reference.largest_code);
    const auto code = [&](float value) { return static_cast<std::int64_t>(value * largest + 0.5f); };
    const auto difference = [&](std::size_t i) { return code(to[i * step]) - code(from[i * step]); };
    return measure<std::int64_t>(difference, 1.0 / reference.largest_code, channels, reference.width,
                                 reference.pixels(), mask);
  }
  const image::CurveTable* const from_curve = curve_of(reference, encoding);
  const image::CurveTable* const to_curve = curve_of(test, encoding);
  const auto difference = [&](std::size_t i) {
    const float before = from[i * step], after = to[i * step];
    // The curve would turn NaN into a number.
    if (!std::isfinite(before) || !std::isfinite(after)) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(to_curve ? to_curve->at(after) : after) -
           static_cast<double>(from_curve ? from_curve->at(before) : before);
  };
  return measure<double>(difference, 1.0, channels, reference.width, reference.pixels(), mask);
}

LayerMetrics layer_metrics(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  require_same_size(reference, test);
  LayerMetrics metrics;
  if (!reference.depth.empty() && !test.depth.empty()) metrics.depth = compare_depth(reference, test, mask);
  metrics.agreement = agreement_metrics(reference, test, mask);
  if (!reference.normals.empty() && !test.normals.empty())
    metrics.normals = compare_normals(reference, test, mask);
  if (!reference.ids.empty() && !test.ids.empty()) metrics.ids = compare_ids(reference, test, mask);
  if (!reference.alpha.empty() && !test.alpha.empty()) metrics.alpha = compare_alpha(reference, test, mask);
  return metrics;
}

}  // namespace alidade::compare
