// SPDX-License-Identifier: MIT
#include "compare/metrics/hdr_flip.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/exact_math.h"
#include "compare/metrics/pair_pixels.h"
#include "compare/metrics/pixel_sums.h"
#include "image/srgb.h"

namespace alidade {
namespace {

using Coefficients = std::array<double, 6>;

/// k0 .. k5 of ToneCurve. Sources: K. Narkowicz's fit of ACES with the exposure 0.6 folded in, J. Hable's
/// curve scaled to its white point, E. Reinhard et al. 2002.
const Coefficients& coefficients(ToneMapper mapper) {
  static constexpr Coefficients k_aces{0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};
  static constexpr Coefficients k_hable{0.231683, 0.013791, 0.0, 0.18, 0.3, 0.018};
  static constexpr Coefficients k_reinhard{0.0, 1.0, 0.0, 0.0, 1.0, 1.0};
  return mapper == ToneMapper::aces ? k_aces : mapper == ToneMapper::hable ? k_hable : k_reinhard;
}

/// The light that the tone mapper brings to 0.85: the larger root of a quadratic equation.
double light_of_target(ToneMapper mapper) {
  constexpr double k_target = 0.85;
  const Coefficients& k = coefficients(mapper);
  const double a = k[0] - k_target * k[3], b = k[1] - k_target * k[4], c = k[2] - k_target * k[5];
  if (a == 0.0) return -c / b;
  const double half = -b / (2.0 * a);
  return half + std::sqrt(half * half - c / a);
}

struct Luminances {
  double most = 0.0, median = 0.0;
};

Luminances measure(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask) {
  ImageMask counted = mask;
  keep_finite(counted, reference, test);
  const PairPixels pixels(reference, test, counted, ColorEncoding::linear);
  const auto value_at = [&](std::size_t pixel) {
    if (!counted.at(pixel)) return -1.0f;
    const auto& rgb = pixels.at(pixel).color[0];
    const float luminance = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
    // Negative light counts as none; sums beyond floats as the most that there is.
    return luminance > 0.0f ? std::min(luminance, 3e38f) : 0.0f;
  };
  const FloatCounts counts = count_upper_halves(reference.pixels(), value_at);
  std::uint64_t total = 0;
  for (const std::uint64_t count : counts.counts) total += count;
  if (total == 0) return {};
  const auto of_rank = [&](std::uint64_t rank) {
    return static_cast<double>(value_of_rank(reference.pixels(), value_at, counts, rank));
  };
  Luminances luminances{of_rank(total - 1), of_rank(total / 2)};
  if (luminances.median <= 0.0 && luminances.most > 0.0) {
    const auto with_light = [&](std::size_t pixel) {
      const float value = value_at(pixel);
      return value > 0.0f ? value : -1.0f;
    };
    const FloatCounts lit = count_upper_halves(reference.pixels(), with_light);
    std::uint64_t lit_total = 0;
    for (const std::uint64_t count : lit.counts) lit_total += count;
    luminances.median = value_of_rank(reference.pixels(), with_light, lit, lit_total / 2);
  }
  return luminances;
}

[[noreturn]] void fail(const std::string& problem, const std::string& expected, const std::string& found) {
  throw Error({.problem = problem, .expected = expected, .found = found});
}

void check(const FlipOptions& options) {
  for (const std::optional<double>& exposure : {options.start_exposure, options.stop_exposure})
    if (exposure && !(std::fabs(*exposure) <= 1000.0))
      fail("exposure out of range", "-1000 to 1000 stops", std::to_string(*exposure));
  if (options.exposures && (*options.exposures < 2 || *options.exposures > k_most_exposures))
    fail("number of exposures out of range", "2 to " + std::to_string(k_most_exposures),
         std::to_string(*options.exposures));
}

}  // namespace

ToneCurve tone_curve(ToneMapper mapper, double exposure) {
  ToneCurve curve;
  curve.kind = mapper == ToneMapper::reinhard ? ToneCurve::Kind::luminance : ToneCurve::Kind::rational;
  // Beyond floats nothing is left of a picture, or all of it is white.
  curve.scale = static_cast<float>(exposure_scale(std::clamp(exposure, -149.0, 127.0)));
  std::ranges::transform(coefficients(mapper), curve.k, [](double k) { return static_cast<float>(k); });
  return curve;
}

ExposureRange exposure_range(const ComparedImage& reference, const ComparedImage& test, const ImageMask& mask,
                             const FlipOptions& options) {
  check(options);
  const Luminances luminances = measure(reference, test, mask);
  const bool is_dark = !(luminances.most > 0.0);
  if (is_dark && !options.start_exposure && !options.stop_exposure) return {};
  const double light = light_of_target(options.tone_mapper);
  const auto found = [&](const std::optional<double>& told, double luminance) {
    return told ? *told : is_dark ? 0.0 : binary_logarithm(light / luminance);
  };
  ExposureRange range;
  range.start = found(options.start_exposure, luminances.most);
  range.stop = found(options.stop_exposure, luminances.median);
  if (range.start > range.stop)
    fail("first exposure above the last", "at most " + std::to_string(range.stop) + " stops",
         std::to_string(range.start));
  const double stops = std::ceil(range.stop - range.start);
  range.count =
      options.exposures.value_or(static_cast<int>(std::clamp(stops, 2.0, double{k_most_exposures})));
  return range;
}

}  // namespace alidade
