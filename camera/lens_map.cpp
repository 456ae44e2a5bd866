// SPDX-License-Identifier: MIT
#include "camera/lens_map.h"

#include <cmath>
#include <numbers>

#include "base/exact_math.h"

// project() and unproject() of each lens are side by side, so that one can be read as the inverse of the
// other.

namespace alidade::camera {
namespace {

using Film = std::optional<glm::dvec2>;
using Seen = std::optional<LensRay>;

constexpr double k_pi = std::numbers::pi;
/// Flatter views than this (89.9999 degrees off the axis) count as beside the film of a perspective lens.
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

Film pinhole(const glm::dvec3& at) {
  if (!(at.z > 0.0)) return std::nullopt;
  return glm::dvec2(at.x / at.z, at.y / at.z);
}

/// The ideal fisheye: theta along (x, y).
Film equidistant(const glm::dvec3& at) {
  const double side = length_of(at.x, at.y);
  if (side == 0.0) return at.z > 0.0 ? Film(glm::dvec2(0.0)) : std::nullopt;
  return glm::dvec2(at.x, at.y) * (angle_of(side, at.z) / side);
}

Film project_field_of_view(double omega, const glm::dvec3& at) {
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

Film project_division(double k, const glm::dvec3& at) {
  const double side_sq = at.x * at.x + at.y * at.y;
  const double under_root = at.z * at.z - 4.0 * k * side_sq;
  if (!(under_root >= 0.0)) return std::nullopt;
  const double root_of = std::sqrt(under_root);
  // Two forms of one number, each where nothing cancels.
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

Film project_unified(const UnifiedLens& lens, const glm::dvec3& at) {
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
  // The film's edges are computed, so they may lie a rounding beyond.
  constexpr double k_slack = 1.0 + 1e-12;
  if (!(std::fabs(film.x) <= k_pi * k_slack && std::fabs(film.y) <= 0.5 * k_pi * k_slack))
    return std::nullopt;
  const SineCosine longitude = sine_cosine(film.x), latitude = sine_cosine(film.y);
  return towards(latitude.cosine * longitude.sine, latitude.sine, latitude.cosine * longitude.cosine);
}

}  // namespace

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

  Film operator()(const PinholeLens&) const { return pinhole(at); }
  Film operator()(const Brown& lens) const {
    const Film ideal = pinhole(at);
    return ideal ? lens.distortion.distort(*ideal) : ideal;
  }
  Film operator()(const Fisheye& lens) const {
    const Film ideal = equidistant(at);
    return ideal ? lens.distortion.distort(*ideal) : ideal;
  }
  Film operator()(const FieldOfViewLens& lens) const {
    return project_field_of_view(std::fabs(lens.omega), at);
  }
  Film operator()(const DivisionLens& lens) const { return project_division(lens.k, at); }
  Film operator()(const UnifiedLens& lens) const { return project_unified(lens, at); }
  Film operator()(const Dual& lens) const {
    const Film straight = pinhole(at);
    if (!straight) return straight;
    return lens.distortion.distort(lens.transition * *straight + (1.0 - lens.transition) * *equidistant(at));
  }
  Film operator()(const OrthographicLens&) const {
    return at.z >= 0.0 ? Film(glm::dvec2(at.x, at.y)) : std::nullopt;
  }
  Film operator()(const EquirectangularLens&) const {
    if (at == glm::dvec3(0.0)) return std::nullopt;
    return glm::dvec2(angle_of(at.x, at.z), angle_of(at.y, length_of(at.x, at.z)));
  }
};

struct LensMap::Unproject {
  const glm::dvec2& film;

  Seen operator()(const PinholeLens&) const { return towards(film.x, film.y, 1.0); }
  Seen operator()(const Brown& lens) const {
    const Film ideal = lens.distortion.undistort(film);
    return ideal ? towards(ideal->x, ideal->y, 1.0) : std::nullopt;
  }
  Seen operator()(const Fisheye& lens) const {
    const Film ideal = lens.distortion.undistort(film);
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
    const Film ideal = lens.distortion.undistort(film);
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
