// SPDX-License-Identifier: MIT
#include "camera/lens_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/exact_math.h"

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

/// The largest numbers before each sign change of the polynomial in (0, end], ascending, exact to the last
/// bit. Double zeros, where it keeps its sign, are left out. Equal bits on every machine.
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

using FilmPosition = std::optional<glm::dvec2>;
using Seen = std::optional<LensRay>;

constexpr double k_pi = std::numbers::pi;
/// Directions beyond this (89.9999 degrees off the axis) miss the film of a perspective lens.
constexpr double k_largest_tangent = 1e6;

double length_of(double x, double y) {
  return std::sqrt(x * x + y * y);
}

Seen towards(double x, double y, double z) {
  return LensRay{.origin = glm::dvec3(0.0), .direction = {x, y, z}};
}

/// `angle` off the axis, towards `side` on the film, which has the length `side_length`.
Seen towards(const glm::dvec2& side, double side_length, double angle) {
  const SineCosine turn = sine_cosine(angle);
  const double scale = side_length > 0.0 ? turn.sine / side_length : 0.0;
  return towards(scale * side.x, scale * side.y, turn.cosine);
}

// project and unproject of a lens are side by side, one the inverse of the other.

FilmPosition pinhole(const glm::dvec3& at) {
  if (!(at.z > 0.0)) return std::nullopt;
  return glm::dvec2(at.x / at.z, at.y / at.z);
}

/// The ideal fisheye: theta along (x, y).
FilmPosition equidistant(const glm::dvec3& at) {
  const double side = length_of(at.x, at.y);
  if (side == 0.0) return at.z > 0.0 ? FilmPosition(glm::dvec2(0.0)) : std::nullopt;
  return glm::dvec2(at.x, at.y) * (angle_of(side, at.z) / side);
}

FilmPosition project_field_of_view(double omega, const glm::dvec3& at) {
  const double side = length_of(at.x, at.y);
  if (!(at.z > 0.0) || omega == 0.0 || side == 0.0) return pinhole(at);
  const SineCosine half = sine_cosine(0.5 * omega);
  const double film_radius = angle_of(2.0 * side * half.sine, at.z * half.cosine) / omega;
  return glm::dvec2(at.x, at.y) * (film_radius / side);
}
Seen unproject_field_of_view(double omega, const glm::dvec2& film) {
  const double film_radius = length_of(film.x, film.y);
  if (omega == 0.0 || film_radius == 0.0) return towards(film.x, film.y, 1.0);
  if (!(film_radius * omega < 0.5 * k_pi)) return std::nullopt;
  const SineCosine half = sine_cosine(0.5 * omega), turn = sine_cosine(film_radius * omega);
  const double scale = turn.sine * half.cosine / (2.0 * half.sine * film_radius);
  return towards(scale * film.x, scale * film.y, turn.cosine);
}

FilmPosition project_division(double k, const glm::dvec3& at) {
  const double side_sq = at.x * at.x + at.y * at.y;
  const double under_root = at.z * at.z - 4.0 * k * side_sq;
  if (!(under_root >= 0.0)) return std::nullopt;
  const double root_of = std::sqrt(under_root);
  // Two forms of the same number, each used where no digits cancel.
  const double scale = at.z > 0.0 ? 2.0 / (at.z + root_of) : (at.z - root_of) / (2.0 * k * side_sq);
  if (!(scale > 0.0) || !std::isfinite(scale)) return std::nullopt;
  if (k > 0.0 && at.z <= 0.0) return std::nullopt;
  return glm::dvec2(scale * at.x, scale * at.y);
}
Seen unproject_division(double k, const glm::dvec2& film) {
  const double turn = k * (film.x * film.x + film.y * film.y);
  // Up to here the view angle grows with the film radius.
  if (!(turn <= 1.0)) return std::nullopt;
  return towards(film.x, film.y, 1.0 + turn);
}

FilmPosition project_unified(const UnifiedLens& lens, const glm::dvec3& at) {
  const double distance = std::sqrt(lens.beta * (at.x * at.x + at.y * at.y) + at.z * at.z);
  const double limit = lens.alpha <= 0.5 ? lens.alpha / (1.0 - lens.alpha) : (1.0 - lens.alpha) / lens.alpha;
  if (!(at.z > -limit * distance)) return std::nullopt;
  const double depth = lens.alpha * distance + (1.0 - lens.alpha) * at.z;
  if (!(depth > 0.0)) return std::nullopt;
  return glm::dvec2(at.x / depth, at.y / depth);
}
Seen unproject_unified(const UnifiedLens& lens, const glm::dvec2& film) {
  const double r_sq = film.x * film.x + film.y * film.y;
  const double under_root = 1.0 - (2.0 * lens.alpha - 1.0) * lens.beta * r_sq;
  if (!(under_root >= 0.0)) return std::nullopt;
  const double below = lens.alpha * std::sqrt(under_root) + 1.0 - lens.alpha;
  if (!(below > 0.0)) return std::nullopt;
  return towards(film.x, film.y, (1.0 - lens.beta * lens.alpha * lens.alpha * r_sq) / below);
}

/// The tangent t for which transition t + (1 - transition) atan t = radius.
double tangent_of_mixture(double transition, double radius) {
  // The left side is concave, so that Newton's method climbs to the answer from below and never passes it.
  double t = radius;
  for (int step = 0; step < 200; ++step) {
    const double excess = transition * t + (1.0 - transition) * angle_of(t, 1.0) - radius;
    const double next = t - excess / (transition + (1.0 - transition) / (1.0 + t * t));
    if (!(next > t)) break;
    t = next;
  }
  return t;
}

Seen unproject_equirectangular(const glm::dvec2& film) {
  // Computed positions on the edges of the film may exceed them by rounding.
  constexpr double k_slack = 1.0 + 1e-12;
  if (!(std::fabs(film.x) <= k_pi * k_slack && std::fabs(film.y) <= 0.5 * k_pi * k_slack))
    return std::nullopt;
  const SineCosine longitude = sine_cosine(film.x), latitude = sine_cosine(film.y);
  return towards(latitude.cosine * longitude.sine, latitude.sine, latitude.cosine * longitude.cosine);
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
  const double film_radius = length_of(film.x, film.y);
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
    const double length = length_of(change.x, change.y);
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

struct LensMap::Prepare {
  template <typename Same>
  decltype(LensMap::lens_) operator()(const Same& lens) const {
    return lens;
  }
  decltype(LensMap::lens_) operator()(const BrownLens& lens) const {
    return Brown{DistortionMap(lens.distortion, k_largest_tangent)};
  }
  decltype(LensMap::lens_) operator()(const FisheyeLens& lens) const {
    return Fisheye{DistortionMap(lens.distortion, k_pi)};
  }
  decltype(LensMap::lens_) operator()(const DualLens& lens) const {
    const double largest = lens.transition * k_largest_tangent + (1.0 - lens.transition) * 0.5 * k_pi;
    return Dual{lens.transition, DistortionMap(lens.distortion, largest)};
  }
};

struct LensMap::Project {
  const glm::dvec3& at;

  FilmPosition operator()(const PinholeLens&) const { return pinhole(at); }
  FilmPosition operator()(const Brown& lens) const {
    const FilmPosition ideal = pinhole(at);
    return ideal ? lens.distortion.distort(*ideal) : ideal;
  }
  FilmPosition operator()(const Fisheye& lens) const {
    const FilmPosition ideal = equidistant(at);
    return ideal ? lens.distortion.distort(*ideal) : ideal;
  }
  FilmPosition operator()(const FieldOfViewLens& lens) const {
    return project_field_of_view(std::fabs(lens.omega), at);
  }
  FilmPosition operator()(const DivisionLens& lens) const { return project_division(lens.k, at); }
  FilmPosition operator()(const UnifiedLens& lens) const { return project_unified(lens, at); }
  FilmPosition operator()(const Dual& lens) const {
    const FilmPosition straight = pinhole(at);
    if (!straight) return straight;
    return lens.distortion.distort(lens.transition * *straight + (1.0 - lens.transition) * *equidistant(at));
  }
  FilmPosition operator()(const OrthographicLens&) const {
    return at.z >= 0.0 ? FilmPosition(glm::dvec2(at.x, at.y)) : std::nullopt;
  }
  FilmPosition operator()(const EquirectangularLens&) const {
    if (at == glm::dvec3(0.0)) return std::nullopt;
    return glm::dvec2(angle_of(at.x, at.z), angle_of(at.y, length_of(at.x, at.z)));
  }
};

struct LensMap::Unproject {
  const glm::dvec2& film;

  Seen operator()(const PinholeLens&) const { return towards(film.x, film.y, 1.0); }
  Seen operator()(const Brown& lens) const {
    const FilmPosition ideal = lens.distortion.undistort(film);
    return ideal ? towards(ideal->x, ideal->y, 1.0) : std::nullopt;
  }
  Seen operator()(const Fisheye& lens) const {
    const FilmPosition ideal = lens.distortion.undistort(film);
    if (!ideal) return std::nullopt;
    const double angle = length_of(ideal->x, ideal->y);
    return towards(*ideal, angle, angle);
  }
  Seen operator()(const FieldOfViewLens& lens) const {
    return unproject_field_of_view(std::fabs(lens.omega), film);
  }
  Seen operator()(const DivisionLens& lens) const { return unproject_division(lens.k, film); }
  Seen operator()(const UnifiedLens& lens) const { return unproject_unified(lens, film); }
  Seen operator()(const Dual& lens) const {
    const FilmPosition ideal = lens.distortion.undistort(film);
    if (!ideal) return std::nullopt;
    const double radius = length_of(ideal->x, ideal->y);
    const double scale = radius > 0.0 ? tangent_of_mixture(lens.transition, radius) / radius : 1.0;
    return towards(scale * ideal->x, scale * ideal->y, 1.0);
  }
  Seen operator()(const OrthographicLens&) const {
    return LensRay{.origin = {film.x, film.y, 0.0}, .direction = {0.0, 0.0, 1.0}};
  }
  Seen operator()(const EquirectangularLens&) const { return unproject_equirectangular(film); }
};

LensMap::LensMap(const Lens& lens) : lens_(std::visit(Prepare{}, lens)) {}

std::optional<glm::dvec2> LensMap::project(const glm::dvec3& point) const {
  return std::visit(Project{point}, lens_);
}

std::optional<LensRay> LensMap::unproject(const glm::dvec2& film) const {
  return std::visit(Unproject{film}, lens_);
}

}  // namespace alidade::camera
