// SPDX-License-Identifier: MIT
#include "camera/lens_map.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace alidade::camera {
namespace {

/// Coefficients, that of x^0 first.
using Polynomial = std::vector<double>;

double value_at(const Polynomial& polynomial, double x) {
  double value = 0.0;
  for (auto each = polynomial.rbegin(); each != polynomial.rend(); ++each) value = value * x + *each;
  return value;
}

Polynomial derivative(const Polynomial& polynomial) {
  Polynomial result;
  for (std::size_t i = 1; i < polynomial.size(); ++i)
    result.push_back(static_cast<double>(i) * polynomial[i]);
  return result;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial result(a.empty() || b.empty() ? 0 : a.size() + b.size() - 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) result[i + j] += a[i] * b[j];
  }
  return result;
}

Polynomial difference(const Polynomial& a, const Polynomial& b) {
  Polynomial result(std::max(a.size(), b.size()));
  std::copy(a.begin(), a.end(), result.begin());
  for (std::size_t i = 0; i < b.size(); ++i) result[i] -= b[i];
  return result;
}

/// The last numbers before the polynomial changes its sign in (0, end], ascending, to the last bit. Double
/// zeros, where it keeps its sign, are left out. Equal bits on every machine.
std::vector<double> sign_changes(const Polynomial& polynomial, double end) {
  if (polynomial.size() < 2) return {};
  // Between two sign changes of the derivative the polynomial is monotone.
  std::vector<double> borders = sign_changes(derivative(polynomial), end);
  borders.push_back(end);
  std::vector<double> changes;
  double low = 0.0;
  for (const double border : borders) {
    double high = border;
    const bool below = value_at(polynomial, low) < 0.0;
    if (below != (value_at(polynomial, high) < 0.0)) {
      for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high))
        ((value_at(polynomial, middle) < 0.0) == below ? low : high) = middle;
      changes.push_back(low);
    }
    low = border;
  }
  return changes;
}

double length_of(const glm::dvec2& v) {
  return std::sqrt(v.x * v.x + v.y * v.y);
}

template <std::size_t count>
Polynomial one_and(const std::array<double, count>& coefficients) {
  Polynomial result{1.0};
  result.insert(result.end(), coefficients.begin(), coefficients.end());
  while (result.size() > 1 && result.back() == 0.0) result.pop_back();
  return result;
}

/// The radius up to which r N(r^2) / D(r^2) grows.
double end_of_growth(const Distortion& distortion, double largest_radius) {
  const Polynomial numerator = one_and(distortion.radial), denominator = one_and(distortion.denominator);
  // The derivative by r is (N D + 2 q (N' D - N D')) / D^2 with q = r^2.
  const Polynomial turn =
      difference(product(derivative(numerator), denominator), product(numerator, derivative(denominator)));
  const Polynomial slope = difference(product(numerator, denominator), product(Polynomial{0.0, -2.0}, turn));
  const double end = largest_radius * largest_radius;
  double limit = end;
  for (const Polynomial& each : {slope, denominator}) {
    const std::vector<double> changes = sign_changes(each, end);
    if (!changes.empty()) limit = std::min(limit, changes.front());
  }
  return limit < end ? std::sqrt(limit) : largest_radius;
}

}  // namespace

DistortionMap::DistortionMap(const Distortion& distortion, double largest_radius)
    : distortion_(distortion),
      radial_count_(one_and(distortion.radial).size() - 1),
      denominator_count_(one_and(distortion.denominator).size() - 1),
      radial_only_(distortion.p1 == 0.0 && distortion.p2 == 0.0 &&
                   distortion.prism == std::array<double, 4>{}),
      ideal_limit_(end_of_growth(distortion, largest_radius)),
      film_limit_(ideal_limit_ * radial_at(ideal_limit_ * ideal_limit_).factor) {}

DistortionMap::Radial DistortionMap::radial_at(double q) const {
  // 1 + q times the polynomial of the first coefficients, and its derivative.
  const auto value_and_slope = [q](const auto& coefficients, std::size_t count) {
    double value = 0.0, slope = 0.0;
    for (std::size_t i = count; i-- > 0;) {
      slope = slope * q + value + coefficients[i];
      value = (value + coefficients[i]) * q;
    }
    return std::pair(value + 1.0, slope);
  };
  const auto [numerator, numerator_slope] = value_and_slope(distortion_.radial, radial_count_);
  if (denominator_count_ == 0) return {numerator, numerator_slope};
  const auto [denominator, denominator_slope] = value_and_slope(distortion_.denominator, denominator_count_);
  const double factor = numerator / denominator;
  return {factor, (numerator_slope - factor * denominator_slope) / denominator};
}

DistortionMap::Moved DistortionMap::moved(const glm::dvec2& ideal) const {
  const double x = ideal.x, y = ideal.y;
  const Radial radial = radial_at(x * x + y * y);
  Moved result{.position = radial.factor * ideal,
               .by_x = {radial.factor + 2.0 * x * x * radial.slope, 2.0 * x * y * radial.slope},
               .by_y = {2.0 * x * y * radial.slope, radial.factor + 2.0 * y * y * radial.slope}};
  if (radial_only_) return result;

  const auto& [s1, s2, s3, s4] = distortion_.prism;
  const double p1 = distortion_.p1, p2 = distortion_.p2;
  const glm::dvec2 at = distortion_.after_radial ? result.position : ideal;
  const double s = at.x * at.x + at.y * at.y;
  const glm::dvec2 shift{2.0 * p1 * at.x * at.y + p2 * (s + 2.0 * at.x * at.x) + s * (s1 + s2 * s),
                         2.0 * p2 * at.x * at.y + p1 * (s + 2.0 * at.y * at.y) + s * (s3 + s4 * s)};
  const double x_turn = 2.0 * (s1 + 2.0 * s2 * s), y_turn = 2.0 * (s3 + 2.0 * s4 * s);
  const glm::dvec2 by_a{2.0 * p1 * at.y + 6.0 * p2 * at.x + x_turn * at.x,
                        2.0 * p2 * at.y + 2.0 * p1 * at.x + y_turn * at.x};
  const glm::dvec2 by_b{2.0 * p1 * at.x + 2.0 * p2 * at.y + x_turn * at.y,
                        2.0 * p2 * at.x + 6.0 * p1 * at.y + y_turn * at.y};
  const glm::dvec2 shift_by_x = distortion_.after_radial ? by_a * result.by_x.x + by_b * result.by_x.y : by_a;
  const glm::dvec2 shift_by_y = distortion_.after_radial ? by_a * result.by_y.x + by_b * result.by_y.y : by_b;
  result.position += shift;
  result.by_x += shift_by_x;
  result.by_y += shift_by_y;
  return result;
}

std::optional<glm::dvec2> DistortionMap::distort(const glm::dvec2& ideal) const {
  if (!(ideal.x * ideal.x + ideal.y * ideal.y <= ideal_limit_ * ideal_limit_)) return std::nullopt;
  const Moved result = moved(ideal);
  if (!(result.by_x.x * result.by_y.y - result.by_x.y * result.by_y.x > 0.0) && !radial_only_)
    return std::nullopt;
  return result.position;
}

std::optional<double> DistortionMap::radius_before(double film_radius) const {
  if (!(film_radius <= film_limit_)) return std::nullopt;
  double low = 0.0, high = ideal_limit_, radius = std::min(film_radius, ideal_limit_);
  for (int step = 0; step < 200; ++step) {
    const Radial radial = radial_at(radius * radius);
    const double excess = radius * radial.factor - film_radius;
    if (excess == 0.0) return radius;
    (excess > 0.0 ? high : low) = radius;
    const double slope = radial.factor + 2.0 * radius * radius * radial.slope;
    double next = radius - excess / slope;
    // A step that leaves the bracket (or a slope of 0) is replaced by halving it.
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::fabs(next - radius) <= 1e-16 * radius || !(next > low && next < high)) return radius;
    radius = next;
  }
  return radius;
}

std::optional<glm::dvec2> DistortionMap::undistort(const glm::dvec2& film) const {
  const double film_radius = length_of(film);
  if (film_radius == 0.0) return glm::dvec2(0.0);
  const std::optional<double> radius = radius_before(film_radius);
  if (!radius) return std::nullopt;
  glm::dvec2 ideal = film * (*radius / film_radius);
  if (radial_only_) return ideal;

  constexpr int k_most_steps = 50;
  double last_step = 0.0;
  for (int step = 0; step < k_most_steps; ++step) {
    const Moved at = moved(ideal);
    const double determinant = at.by_x.x * at.by_y.y - at.by_x.y * at.by_y.x;
    if (!(determinant > 0.0)) return std::nullopt;
    const glm::dvec2 excess = at.position - film;
    const glm::dvec2 change{(at.by_y.y * excess.x - at.by_y.x * excess.y) / determinant,
                            (at.by_x.x * excess.y - at.by_x.y * excess.x) / determinant};
    const double length = length_of(change);
    // Newton's method doubles its digits until rounding stops it: the first step that is not shorter.
    const bool done = length <= 1e-15 * film_radius || (step > 0 && length < 1e-9 && length >= last_step);
    if (done) {
      const bool inside = ideal.x * ideal.x + ideal.y * ideal.y <= ideal_limit_ * ideal_limit_;
      return inside ? std::optional(ideal) : std::nullopt;
    }
    ideal -= change;
    last_step = length;
  }
  return std::nullopt;
}

}  // namespace alidade::camera
