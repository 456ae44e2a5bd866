// SPDX-License-Identifier: MIT
#include "compare/metrics/error_metrics.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/exact_math.h"
#include "compare/metrics/row_sums.h"
#include "image/srgb.h"

namespace alidade {
namespace {

/// Of one row.
template <class Number>
struct RowErrors {
  DifferenceSums<Number> differences;
  std::uint64_t excluded = 0;

  void add(const RowErrors& later) {
    differences.add(later.differences);
    excluded += later.excluded;
  }
};

/// What there is to compare: pair(i) gives the test's value less the reference's, as Number.
template <class Number, class Difference>
class Errors {
 public:
  Errors(const Difference& difference, int channels, int width, std::size_t pixels, const ImageMask& mask)
      : difference_(difference),
        channels_(static_cast<std::size_t>(channels)),
        width_(static_cast<std::size_t>(width)),
        pixels_(pixels),
        mask_(mask) {}

  /// `unit`: what a difference of 1 means.
  ErrorMetrics measure(double unit) const {
    const auto all = sum_rows<RowErrors<Number>>(
        pixels_ / width_, [&](std::size_t y, RowErrors<Number>& sums) { add_row(y, sums); });
    return metrics(all, unit);
  }

 private:
  static bool is_finite(Number number) {
    // Whole numbers always are.
    if constexpr (std::is_floating_point_v<Number>) return std::isfinite(number);
    return true;
  }

  bool is_finite_pixel(std::size_t pixel) const {
    for (std::size_t i = 0; i < channels_; ++i)
      if (!is_finite(difference_(channels_ * pixel + i))) return false;
    return true;
  }

  void add_row(std::size_t y, RowErrors<Number>& sums) const {
    for (std::size_t pixel = y * width_; pixel < (y + 1) * width_; ++pixel) {
      if (!mask_.at(pixel)) continue;
      DifferenceSums<Number> of_pixel;
      for (std::size_t i = channels_ * pixel; i < channels_ * (pixel + 1); ++i)
        of_pixel.add(difference_(i), i);
      // A value that is no number makes none of the sum.
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
      const std::size_t pixel = sums.most_at / channels_;
      metrics.max_x = static_cast<int>(pixel % width_);
      metrics.max_y = static_cast<int>(pixel / width_);
      metrics.max_channel = static_cast<int>(sums.most_at % channels_);
    }
    const bool do_all_count = mask_.counts.empty() && all.excluded == 0;
    const auto value_at = [&](std::size_t i) {
      if (!do_all_count) {
        const std::size_t pixel = i / channels_;
        if (!mask_.at(pixel) || (all.excluded > 0 && !is_finite_pixel(pixel))) return -1.0f;
      }
      return std::fabs(static_cast<float>(difference_(i)));
    };
    metrics.percentile_95 = percentile_95(pixels_ * channels_, value_at, sums.values) * unit;
    return metrics;
  }

  const Difference& difference_;
  const std::size_t channels_, width_, pixels_;
  const ImageMask& mask_;
};

template <class Number, class Difference>
ErrorMetrics measure(const Difference& difference, double unit, int channels, int width, std::size_t pixels,
                     const ImageMask& mask) {
  return Errors<Number, Difference>(difference, channels, width, pixels, mask).measure(unit);
}

/// A curve, or none.
const CurveTable* curve_of(const ComparedImage& image, ColorEncoding encoding) {
  if (image.encoding == encoding) return nullptr;
  return encoding == ColorEncoding::linear ? &linear_from_srgb_table() : &srgb_from_linear_table();
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
  require_same_size(reference, test);
  for (const ComparedImage* const image : {&reference, &test})
    if (image->color_channels == 0)
      throw Error(
          {.file = image->file.string(), .problem = "no colour to compare", .expected = "channels R G B"});
  const int channels = reference.color_channels == 1 && test.color_channels == 1 ? 1 : 3;
  // Colours are stored three per pixel; of grey pictures the first says all.
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
  const CurveTable* const from_curve = curve_of(reference, encoding);
  const CurveTable* const to_curve = curve_of(test, encoding);
  const auto difference = [&](std::size_t i) {
    const float before = from[i * step], after = to[i * step];
    // The curve would make a number of what is none.
    if (!std::isfinite(before) || !std::isfinite(after)) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(to_curve ? to_curve->at(after) : after) -
           static_cast<double>(from_curve ? from_curve->at(before) : before);
  };
  return measure<double>(difference, 1.0, channels, reference.width, reference.pixels(), mask);
}

}  // namespace alidade
