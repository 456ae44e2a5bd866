// SPDX-License-Identifier: MIT
#include "compare/metrics/flip_filters.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/exact_math.h"

namespace alidade {
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

/// Without the outer taps that no float notices.
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

}  // namespace

FlipFilters flip_filters(double pixels_per_degree) {
  if (!(pixels_per_degree >= 1.0 && pixels_per_degree <= 1000.0)) {
    throw Error({.problem = "pixels per degree out of range",
                 .expected = "1 to 1000",
                 .found = std::to_string(pixels_per_degree)});
  }
  FlipFilters filters;
  add_sensitivities(filters, pixels_per_degree);
  add_features(filters, pixels_per_degree);
  for (const HalfTaps* const taps :
       {&filters.achromatic, &filters.red_green, &filters.blue_yellow, &filters.blue_yellow_wide,
        &filters.smooth, &filters.edge, &filters.point})
    filters.radius = std::max(filters.radius, static_cast<int>(taps->size()) - 1);
  return filters;
}

}  // namespace alidade
