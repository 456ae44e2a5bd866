// SPDX-License-Identifier: MIT
#include "compare/metrics/flip_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/exact_math.h"
#include "compare/metrics/pixel_sums.h"
#include "image/srgb.h"

namespace alidade::compare {
namespace {

/// Taps in double, as half.
using Taps = std::vector<double>;

double whole_sum(const Taps& half) {
  double sum = 0.0;
  for (std::size_t k = half.size() - 1; k > 0; --k) sum += 2.0 * half[k];
  return sum + half[0];
}

HalfTaps scaled(const Taps& half, double factor) {
  HalfTaps result;
  for (const double tap : half) result.push_back(static_cast<float>(tap * factor));
  return result;
}

/// Without the outer taps that do not change a sum of floats.
HalfTaps trimmed(HalfTaps half) {
  constexpr float k_unnoticed = 1e-10f;
  while (half.size() > 1 && half.back() < k_unnoticed) half.pop_back();
  return half;
}

/// amplitude * exp(-pi^2 x^2 / b) with x in degrees.
Taps sensitivity(double amplitude, double b, int radius, double pixels_per_degree) {
  Taps half;
  for (int k = 0; k <= radius; ++k) {
    const double x = std::numbers::pi * k / pixels_per_degree;
    half.push_back(amplitude * exponential(std::max(-x * x / b, -700.0)));
  }
  return half;
}

void add_sensitivities(FlipFilters& filters, double pixels_per_degree) {
  constexpr double k_achromatic = 0.0047, k_red_green = 0.0053, k_blue = 0.04, k_blue_wide = 0.025;
  constexpr double k_blue_weight = 34.1, k_blue_wide_weight = 13.5;
  const double deviation = std::sqrt(k_blue / (2.0 * std::numbers::pi * std::numbers::pi));
  const int radius = static_cast<int>(std::ceil(3.0 * deviation * pixels_per_degree));
  for (const auto& [b, taps] :
       {std::pair{k_achromatic, &filters.achromatic}, std::pair{k_red_green, &filters.red_green}}) {
    const Taps half = sensitivity(1.0, b, radius, pixels_per_degree);
    *taps = trimmed(scaled(half, 1.0 / whole_sum(half)));
  }
  // Of a two-dimensional Gaussian of weight a sqrt(pi / b) each direction takes the square root.
  const auto blue = [&](double weight, double b) {
    return sensitivity(std::sqrt(weight * std::sqrt(std::numbers::pi / b)), b, radius, pixels_per_degree);
  };
  const Taps first = blue(k_blue_weight, k_blue), second = blue(k_blue_wide_weight, k_blue_wide);
  const double first_sum = whole_sum(first), second_sum = whole_sum(second);
  const double factor = 1.0 / std::sqrt(first_sum * first_sum + second_sum * second_sum);
  filters.blue_yellow = scaled(first, factor);
  filters.blue_yellow_wide = scaled(second, factor);
}

void add_features(FlipFilters& filters, double pixels_per_degree) {
  constexpr double k_feature_width = 0.082;  // degrees
  const double deviation = 0.5 * k_feature_width * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3.0 * deviation));
  Taps smooth, edge, point;
  double edge_sum = 0.0, positive = 0.0, negative = 0.0;
  for (int k = 0; k <= radius; ++k) {
    const double squares = k / deviation * (k / deviation), bell = exponential(-0.5 * squares);
    smooth.push_back(bell);
    // Of the pixel to the right; the one to the left has the opposite sign.
    edge.push_back(-k * bell);
    edge_sum += k * bell;
    point.push_back((squares - 1.0) * bell);
    (point.back() > 0.0 ? positive : negative) += (k == 0 ? 1.0 : 2.0) * std::fabs(point.back());
  }
  // At few pixels per degree all taps but the middle one are positive or none is.
  for (double& tap : point) tap /= std::max(tap > 0.0 ? positive : negative, 1e-300);
  filters.smooth = scaled(smooth, 1.0 / whole_sum(smooth));
  filters.edge = scaled(edge, 1.0 / std::max(edge_sum, 1e-300));
  filters.point = scaled(point, 1.0);
}

constexpr double k_xyz_from_rgb[3][3] = {
    {10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
    {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
    {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};
constexpr double k_rgb_from_xyz[3][3] = {{3.241003275, -1.537398934, -0.498615861},
                                         {-0.969224334, 1.875930071, 0.041554224},
                                         {0.055639423, -0.204011202, 1.057148933}};

constexpr double white(int row) {
  return k_xyz_from_rgb[row][0] + k_xyz_from_rgb[row][1] + k_xyz_from_rgb[row][2];
}

/// CIE 15: the cube root, a straight line near black.
double lab_curve(double value) {
  constexpr double k_knee = 6.0 / 29.0;
  return value > k_knee * k_knee * k_knee ? root(value, 3) : value / (3.0 * k_knee * k_knee) + 4.0 / 29.0;
}

/// A colour in CIE L*a*b* after the Hunt effect: a and b times 0.01 L.
struct HuntColor {
  double lightness, a, b;
};
HuntColor hunt_color(double x, double y, double z) {
  const double fx = lab_curve(x), fy = lab_curve(y), fz = lab_curve(z);
  const double lightness = 116.0 * fy - 16.0;
  return {lightness, 0.01 * lightness * 500.0 * (fx - fy), 0.01 * lightness * 200.0 * (fy - fz)};
}

/// HyAB distance.
double color_distance(const HuntColor& one, const HuntColor& other) {
  const double a = one.a - other.a, b = one.b - other.b;
  return std::fabs(one.lightness - other.lightness) + std::sqrt(a * a + b * b);
}

HuntColor of_primary(int primary) {
  return hunt_color(k_xyz_from_rgb[0][primary] / white(0), k_xyz_from_rgb[1][primary] / white(1),
                    k_xyz_from_rgb[2][primary] / white(2));
}

FlipColor make_flip_color() {
  FlipColor color{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      color.xyz_from_rgb[row][column] = static_cast<float>(k_xyz_from_rgb[row][column] / white(row));
      color.rgb_from_xyz[row][column] = static_cast<float>(k_rgb_from_xyz[row][column] * white(column));
    }
  }
  // d^0.7 = (2 (d / 1024)^(1/10))^7; distances of colours are below 1024.
  const double base = 2.0 * root(color_distance(of_primary(1), of_primary(2)) / 1024.0, 10);
  const double cube = base * base * base;
  color.largest_difference = static_cast<float>(cube * cube * base);
  return color;
}

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

void check(const FlipOptions& options) {
  for (const std::optional<double>& exposure : {options.start_exposure, options.stop_exposure})
    if (exposure)
      check_that(std::fabs(*exposure) <= 1000.0, "exposure out of range", "-1000 to 1000 stops",
                 std::to_string(*exposure));
  const int exposures = options.exposures.value_or(2);
  check_that(exposures >= 2 && exposures <= k_most_exposures, "number of exposures out of range",
             "2 to " + std::to_string(k_most_exposures), std::to_string(exposures));
}

}  // namespace

FlipFilters flip_filters(double pixels_per_degree) {
  check_that(pixels_per_degree >= 1.0 && pixels_per_degree <= 1000.0, "pixels per degree out of range",
             "1 to 1000", std::to_string(pixels_per_degree));
  FlipFilters filters;
  add_sensitivities(filters, pixels_per_degree);
  add_features(filters, pixels_per_degree);
  for (const HalfTaps* const taps :
       {&filters.achromatic, &filters.red_green, &filters.blue_yellow, &filters.blue_yellow_wide,
        &filters.smooth, &filters.edge, &filters.point})
    filters.radius = std::max(filters.radius, static_cast<int>(taps->size()) - 1);
  return filters;
}

const FlipColor& flip_color() {
  static const FlipColor color = make_flip_color();
  return color;
}

ToneCurve tone_curve(ToneMapper mapper, double exposure) {
  ToneCurve curve;
  curve.kind = mapper == ToneMapper::reinhard ? ToneCurve::Kind::luminance : ToneCurve::Kind::rational;
  // Beyond floats nothing is left of an image, or all of it is white.
  curve.scale = static_cast<float>(image::exposure_scale(std::clamp(exposure, -149.0, 127.0)));
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
  const auto found = [&](const std::optional<double>& given, double luminance) {
    return given ? *given : is_dark ? 0.0 : binary_logarithm(light / luminance);
  };
  ExposureRange range;
  range.start = found(options.start_exposure, luminances.most);
  range.stop = found(options.stop_exposure, luminances.median);
  check_that(!(range.start > range.stop), "start exposure above the stop exposure",
             "at most " + std::to_string(range.stop) + " stops", std::to_string(range.start));
  const double stops = std::ceil(range.stop - range.start);
  range.count =
      options.exposures.value_or(static_cast<int>(std::clamp(stops, 2.0, double{k_most_exposures})));
  return range;
}

}  // namespace alidade::compare
