// SPDX-License-Identifier: MIT
#include "simulation/shapes.h"

#include <algorithm>
#include <cmath>

#include "base/exact_math.h"

namespace alidade::simulation::shapes {

namespace {

/// Eases from 0 to 1 over [0, 1] with two continuous derivatives.
struct Ease {
  double value = 0.0, slope = 0.0;
};
constexpr double k_steepest_ease = 1.875;         // largest slope of 6x^5 - 15x^4 + 10x^3, at x = 1/2
constexpr double k_strongest_bend = 5.773502692;  // largest second derivative, 10 / sqrt(3)

Ease ease(double x) {
  if (x <= 0.0) return {0.0, 0.0};
  if (x >= 1.0) return {1.0, 0.0};
  return {x * x * x * (10.0 + x * (6.0 * x - 15.0)), 30.0 * x * x * (1.0 - x) * (1.0 - x)};
}

/// Bound on the second derivative of the height along any level direction: of fade * waves by the product
/// rule, where fade = ease_x + ease_y - ease_x * ease_y.
double curvature_bound(const Ground& ground) {
  double value = 0.0, slope = 0.0, bend = 0.0;
  for (const Wave& wave : ground.waves) {
    const double amplitude = std::fabs(wave.amplitude);
    const double frequency = std::fabs(wave.frequency.x) + std::fabs(wave.frequency.y);
    value += amplitude;
    slope += amplitude * frequency;
    bend += amplitude * frequency * frequency;
  }
  const double width = ground.fade_width;
  const double fade_slope = 1.4142135624 * k_steepest_ease / width;
  const double fade_bend = (k_strongest_bend + k_steepest_ease * k_steepest_ease) / (width * width);
  return fade_bend * value + 2.0 * fade_slope * slope + bend;
}

bool in_core(const Ground& ground, const glm::dvec3& position) {
  return std::fabs(position.x) <= ground.core.x && std::fabs(position.y) <= ground.core.y;
}

/// Clips the ray's interval to where it can meet the ground: over its rectangle and
/// between its extreme heights.
bool clip(const Ground& ground, Ray& ray) {
  const glm::dvec3 reach(ground.half_size.x, ground.half_size.y, amplitude_of(ground));
  for (int axis = 0; axis < 3; ++axis) {
    if (ray.direction[axis] == 0.0) {
      if (std::fabs(ray.origin[axis]) > reach[axis]) return false;
      continue;
    }
    const double low = (-reach[axis] - ray.origin[axis]) / ray.direction[axis];
    const double high = (reach[axis] - ray.origin[axis]) / ray.direction[axis];
    ray.t_min = std::max(ray.t_min, std::min(low, high));
    ray.t_max = std::min(ray.t_max, std::max(low, high));
  }
  return ray.t_min <= ray.t_max;
}

}  // namespace

double amplitude_of(const Ground& ground) {
  double sum = 0.0;
  for (const Wave& wave : ground.waves) sum += std::fabs(wave.amplitude);
  return sum;
}

GroundHeight height_at(const Ground& ground, const glm::dvec2& position) {
  const Ease x = ease((std::fabs(position.x) - ground.core.x) / ground.fade_width);
  const Ease y = ease((std::fabs(position.y) - ground.core.y) / ground.fade_width);
  const double fade = x.value + y.value - x.value * y.value;
  if (fade == 0.0) return {};
  double sum = 0.0;
  glm::dvec2 slope(0.0);
  for (const Wave& wave : ground.waves) {
    const SineCosine turn =
        sine_cosine_by_quarters(wave.frequency.x * position.x + wave.frequency.y * position.y + wave.phase);
    sum += wave.amplitude * turn.sine;
    slope += wave.amplitude * turn.cosine * wave.frequency;
  }
  const double fade_x = x.slope * (1.0 - y.value) / ground.fade_width * (position.x < 0.0 ? -1.0 : 1.0);
  const double fade_y = y.slope * (1.0 - x.value) / ground.fade_width * (position.y < 0.0 ? -1.0 : 1.0);
  return {fade * sum, {fade * slope.x + fade_x * sum, fade * slope.y + fade_y * sum}};
}

std::optional<double> intersect_ground(const Ground& ground, const Ray& whole_ray) {
  constexpr double k_close_enough = 1e-12;
  Ray ray = whole_ray;
  if (!clip(ground, ray)) return std::nullopt;

  if (ray.direction.z != 0.0 && in_core(ground, ray.position(ray.t_min))) {
    const double level = -ray.origin.z / ray.direction.z;
    // The core is convex: between two points over it the ground is the plane.
    if (level >= ray.t_min && in_core(ground, ray.position(level))) {
      if (level <= ray.t_max) return level;
      return std::nullopt;
    }
  }

  const double level_speed_sq = ray.direction.x * ray.direction.x + ray.direction.y * ray.direction.y;
  const double bend = curvature_bound(ground) * level_speed_sq;
  double t = ray.t_min;
  while (t <= ray.t_max) {
    const glm::dvec3 position = ray.position(t);
    const GroundHeight height = height_at(ground, {position.x, position.y});
    double gap = position.z - height.height;
    double closing = ray.direction.z - height.slope.x * ray.direction.x - height.slope.y * ray.direction.y;
    if (gap < 0.0) gap = -gap, closing = -closing;
    if (gap <= k_close_enough) return t;
    if (bend == 0.0 && closing >= 0.0) return std::nullopt;
    // gap + closing * s - bend / 2 * s^2 is a lower bound of the gap after s more metres; up to
    // its root the ray is free.
    const double root = std::sqrt(closing * closing + 2.0 * bend * gap);
    const double step = closing < 0.0 ? 2.0 * gap / (root - closing) : (closing + root) / bend;
    if (!(t + step > t)) return t;
    t += step;
  }
  return std::nullopt;
}

}  // namespace alidade::simulation::shapes
