// SPDX-License-Identifier: MIT
#include "simulation/shapes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "base/exact_math.h"

namespace alidade::simulation::shapes {

namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

bool within(const Ray& ray, double t) {
  return t >= ray.t_min && t <= ray.t_max;
}

/// The smaller of near <= far that lies in the ray's interval.
std::optional<double> first_within(const Ray& ray, double near, double far) {
  if (within(ray, near)) return near;
  if (within(ray, far)) return far;
  return std::nullopt;
}

/// The nearer end of a chord that lies in the ray's interval.
std::optional<double> chord_within(const Ray& ray, double middle, double half_chord_sq) {
  if (half_chord_sq < 0.0) return std::nullopt;
  const double half_chord = std::sqrt(half_chord_sq);
  return first_within(ray, middle - half_chord, middle + half_chord);
}

/// Where a ray enters and leaves a convex region, and through which of its sides.
struct Crossing {
  double enter = -k_infinity, exit = k_infinity;
  int enter_side = -1, exit_side = -1;
  bool empty() const { return !(enter <= exit); }
};

std::optional<double> first_within(const Ray& ray, const Crossing& crossing) {
  return crossing.empty() ? std::nullopt : first_within(ray, crossing.enter, crossing.exit);
}

Crossing cross_box(const Box& box, const Ray& ray) {
  const glm::dvec3 origin = (ray.origin - box.center) * box.axes, direction = ray.direction * box.axes;
  const glm::dvec3& half_size = box.half_size;
  Crossing crossing;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (std::fabs(origin[axis]) > half_size[axis]) return {1.0, 0.0, -1, -1};
      continue;
    }
    const bool forward = direction[axis] > 0.0;
    const double near = ((forward ? -half_size[axis] : half_size[axis]) - origin[axis]) / direction[axis];
    const double far = ((forward ? half_size[axis] : -half_size[axis]) - origin[axis]) / direction[axis];
    if (near > crossing.enter) crossing.enter = near, crossing.enter_side = 2 * axis + (forward ? 0 : 1);
    if (far < crossing.exit) crossing.exit = far, crossing.exit_side = 2 * axis + (forward ? 1 : 0);
  }
  return crossing;
}

/// Where the ray meets a plane.
std::optional<double> cross_plane(const glm::dvec3& position, const glm::dvec3& normal, const Ray& ray) {
  const double slope = glm::dot(ray.direction, normal);
  if (slope == 0.0) return std::nullopt;
  const double t = glm::dot(position - ray.origin, normal) / slope;
  return within(ray, t) ? std::optional(t) : std::nullopt;
}

std::optional<double> intersect_shape(const Sphere& sphere, const Ray& ray) {
  // From the perpendicular, which has no cancellation however far the sphere is.
  const glm::dvec3 to_center = sphere.center - ray.origin;
  const double middle = glm::dot(to_center, ray.direction);
  const glm::dvec3 perpendicular = to_center - middle * ray.direction;
  return chord_within(ray, middle, sphere.radius * sphere.radius - glm::dot(perpendicular, perpendicular));
}

std::optional<double> intersect_shape(const Ellipsoid& ellipsoid, const Ray& ray) {
  const glm::dvec3 origin = (ellipsoid.center - ray.origin) / ellipsoid.radii;
  const glm::dvec3 direction = ray.direction / ellipsoid.radii;
  const double length_sq = glm::dot(direction, direction);
  const double middle = glm::dot(origin, direction) / length_sq;
  const glm::dvec3 perpendicular = origin - middle * direction;
  return chord_within(ray, middle, (1.0 - glm::dot(perpendicular, perpendicular)) / length_sq);
}

std::optional<double> intersect_shape(const Frustum& frustum, const Ray& ray) {
  // |across(t)|^2 = radius(height(t))^2, where height and radius are linear in t: a t^2 + 2 b t + c = 0.
  const glm::dvec3 from_base = ray.origin - frustum.base;
  const double height = glm::dot(from_base, frustum.axis), climb = glm::dot(ray.direction, frustum.axis);
  const glm::dvec3 across = from_base - height * frustum.axis, drift = ray.direction - climb * frustum.axis;
  const double taper = (frustum.top_radius - frustum.base_radius) / frustum.length;
  const double radius = frustum.base_radius + taper * height;
  const double a = glm::dot(drift, drift) - taper * taper * climb * climb;
  const double b = glm::dot(across, drift) - radius * taper * climb;
  const double c = glm::dot(across, across) - radius * radius;
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return std::nullopt;
  if (a == 0.0 && b == 0.0) return std::nullopt;  // along the mantle of a cylinder
  // First the root without cancellation, then the other from the product of both.
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  double near = q != 0.0 ? c / q : 0.0;
  double far = a != 0.0 ? q / a : near;
  if (near > far) std::swap(near, far);
  for (const double t : {near, far}) {
    const double along = height + t * climb;
    if (!within(ray, t) || along < 0.0 || along > frustum.length) continue;
    if (glm::dot(from_base + t * ray.direction, frustum.keep) < 0.0) continue;
    return t;
  }
  return std::nullopt;
}

std::optional<double> intersect_shape(const Disc& disc, const Ray& ray) {
  const std::optional<double> t = cross_plane(disc.center, disc.normal, ray);
  if (!t) return std::nullopt;
  const glm::dvec3 radial = ray.origin + *t * ray.direction - disc.center;
  const double distance_sq = glm::dot(radial, radial);
  if (distance_sq > disc.radius * disc.radius || distance_sq < disc.inner_radius * disc.inner_radius)
    return std::nullopt;
  return t;
}

std::optional<double> intersect_shape(const Box& box, const Ray& ray) {
  return first_within(ray, cross_box(box, ray));
}

std::optional<double> intersect_shape(const Niche& niche, const Ray& ray) {
  constexpr int k_open_side = 5;
  const Crossing crossing = cross_box(niche.box, ray);
  if (crossing.empty()) return std::nullopt;
  if (crossing.enter_side != k_open_side && within(ray, crossing.enter)) return crossing.enter;
  if (crossing.exit_side != k_open_side && within(ray, crossing.exit)) return crossing.exit;
  return std::nullopt;
}

bool inside(const Opening& opening, double u, double v) {
  if (!(u > opening.min.x && u < opening.max.x && v > opening.min.y && v < opening.max.y)) return false;
  if (!opening.arched) return true;
  const double radius = 0.5 * (opening.max.x - opening.min.x);
  const double from_middle = u - opening.min.x - radius, above_spring = v - (opening.max.y - radius);
  return above_spring <= 0.0 || from_middle * from_middle + above_spring * above_spring < radius * radius;
}

std::optional<double> intersect_shape(const Panel& panel, const Ray& ray) {
  const std::optional<double> t = cross_plane(panel.corner, glm::cross(panel.u_axis, panel.v_axis), ray);
  if (!t) return std::nullopt;
  const glm::dvec3 from_corner = ray.origin + *t * ray.direction - panel.corner;
  const double u = glm::dot(from_corner, panel.u_axis), v = glm::dot(from_corner, panel.v_axis);
  if (!(u >= 0.0 && u <= panel.size.x && v >= 0.0 && v <= panel.size.y)) return std::nullopt;
  for (const Opening& opening : panel.openings)
    if (inside(opening, u, v)) return std::nullopt;
  return t;
}

/// At right angles to the polygon, not of length 1.
glm::dvec3 area_vector(const Polygon& polygon) {
  return glm::cross(polygon.corners[1] - polygon.corners[0], polygon.corners[2] - polygon.corners[0]);
}

std::optional<double> intersect_shape(const Polygon& polygon, const Ray& ray) {
  const glm::dvec3 normal = area_vector(polygon);
  const std::optional<double> t = cross_plane(polygon.corners[0], normal, ray);
  if (!t) return std::nullopt;
  const glm::dvec3 position = ray.origin + *t * ray.direction;
  const std::size_t count = polygon.corners.size();
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3& corner = polygon.corners[i];
    const glm::dvec3 edge = polygon.corners[(i + 1) % count] - corner;
    if (glm::dot(glm::cross(edge, position - corner), normal) < 0.0) return std::nullopt;
  }
  return t;
}

std::optional<double> intersect_shape(const ConvexSolid& solid, const Ray& ray) {
  Crossing crossing;
  for (const HalfSpace& side : solid.sides) {
    const double slope = glm::dot(ray.direction, side.normal);
    const double room = side.offset - glm::dot(ray.origin, side.normal);
    if (slope == 0.0) {
      if (room < 0.0) return std::nullopt;
    } else if (slope < 0.0) {
      crossing.enter = std::max(crossing.enter, room / slope);
    } else {
      crossing.exit = std::min(crossing.exit, room / slope);
    }
  }
  return first_within(ray, crossing);
}

std::optional<double> intersect_shape(const Ground& ground, const Ray& ray) {
  return intersect_ground(ground, ray);
}

SurfacePoint surface_of(const Sphere& sphere, const glm::dvec3& position) {
  return {glm::normalize(position - sphere.center), {}, 0};
}

SurfacePoint surface_of(const Ellipsoid& ellipsoid, const glm::dvec3& position) {
  return {glm::normalize((position - ellipsoid.center) / (ellipsoid.radii * ellipsoid.radii)), {}, 0};
}

SurfacePoint surface_of(const Frustum& frustum, const glm::dvec3& position) {
  const glm::dvec3 from_base = position - frustum.base;
  const double height = glm::dot(from_base, frustum.axis);
  const glm::dvec3 outward = glm::normalize(from_base - height * frustum.axis);
  const double taper = (frustum.top_radius - frustum.base_radius) / frustum.length;
  return {glm::normalize(outward - taper * frustum.axis), {0.0, height}, 0};
}

SurfacePoint surface_of(const Disc& disc, const glm::dvec3& position) {
  return {disc.normal, {glm::length(position - disc.center), 0.0}, 0};
}

/// A niche is a box without +z, seen from within.
SurfacePoint surface_of(const Box& box, const glm::dvec3& position, bool is_niche = false) {
  const glm::dvec3 local = (position - box.center) * box.axes;
  const double gaps[] = {std::fabs(box.half_size.x - std::fabs(local.x)),
                         std::fabs(box.half_size.y - std::fabs(local.y)),
                         std::fabs(box.half_size.z - (is_niche ? -local.z : std::fabs(local.z)))};
  const int axis = static_cast<int>(std::min_element(gaps, gaps + 3) - gaps);
  const bool positive = !(is_niche && axis == 2) && local[axis] > 0.0;
  const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
  return {positive != is_niche ? box.axes[axis] : -box.axes[axis],
          {local[first] + box.half_size[first], local[second] + box.half_size[second]},
          2 * axis + (positive ? 1 : 0)};
}

SurfacePoint surface_of(const Niche& niche, const glm::dvec3& position) {
  return surface_of(niche.box, position, true);
}

SurfacePoint surface_of(const Panel& panel, const glm::dvec3& position) {
  const glm::dvec3 from_corner = position - panel.corner;
  return {glm::cross(panel.u_axis, panel.v_axis),
          {glm::dot(from_corner, panel.u_axis), glm::dot(from_corner, panel.v_axis)},
          0};
}

SurfacePoint surface_of(const Polygon& polygon, const glm::dvec3&) {
  return {glm::normalize(area_vector(polygon)), {}, 0};
}

SurfacePoint surface_of(const ConvexSolid& solid, const glm::dvec3& position) {
  std::size_t nearest = 0;
  double closest = k_infinity;
  for (std::size_t i = 0; i < solid.sides.size(); ++i) {
    const double gap = std::fabs(solid.sides[i].offset - glm::dot(position, solid.sides[i].normal));
    if (gap < closest) closest = gap, nearest = i;
  }
  return {solid.sides[nearest].normal, {}, static_cast<int>(nearest)};
}

SurfacePoint surface_of(const Ground& ground, const glm::dvec3& position) {
  const glm::dvec2 plan(position.x, position.y);
  const GroundHeight height = height_at(ground, plan);
  int face = 0;
  for (const Patch& patch : ground.patches) {
    const glm::dvec2 offset = (plan - patch.center) / patch.half_size;
    const bool covers = patch.round ? glm::dot(offset, offset) <= 1.0
                                    : std::fabs(offset.x) <= 1.0 && std::fabs(offset.y) <= 1.0;
    if (covers) face = patch.face;
  }
  return {glm::normalize(glm::dvec3(-height.slope.x, -height.slope.y, 1.0)), plan, face};
}

/// Around a flat circle.
Bounds bounds_of_circle(const glm::dvec3& center, const glm::dvec3& normal, double radius) {
  glm::dvec3 reach;
  for (int axis = 0; axis < 3; ++axis)
    reach[axis] = radius * std::sqrt(std::max(0.0, 1.0 - normal[axis] * normal[axis]));
  return {center - reach, center + reach};
}

struct BoundsOf {
  Bounds operator()(const Sphere& ball) const {
    return {ball.center - ball.radius, ball.center + ball.radius};
  }
  Bounds operator()(const Ellipsoid& body) const {
    return {body.center - body.radii, body.center + body.radii};
  }
  Bounds operator()(const Frustum& frustum) const {
    Bounds bounds = bounds_of_circle(frustum.base, frustum.axis, frustum.base_radius);
    const glm::dvec3 top = frustum.base + frustum.length * frustum.axis;
    bounds.grow(bounds_of_circle(top, frustum.axis, frustum.top_radius));
    return bounds;
  }
  Bounds operator()(const Disc& disc) const {
    return bounds_of_circle(disc.center, disc.normal, disc.radius);
  }
  Bounds operator()(const Box& box) const {
    const glm::dvec3 reach = glm::abs(box.axes[0]) * box.half_size.x +
                             glm::abs(box.axes[1]) * box.half_size.y +
                             glm::abs(box.axes[2]) * box.half_size.z;
    return {box.center - reach, box.center + reach};
  }
  Bounds operator()(const Niche& niche) const { return (*this)(niche.box); }
  Bounds operator()(const Panel& panel) const {
    Bounds bounds;
    for (const double u : {0.0, panel.size.x})
      for (const double v : {0.0, panel.size.y})
        bounds.grow(panel.corner + u * panel.u_axis + v * panel.v_axis);
    return bounds;
  }
  Bounds operator()(const Polygon& polygon) const {
    Bounds bounds;
    for (const glm::dvec3& corner : polygon.corners) bounds.grow(corner);
    return bounds;
  }
  Bounds operator()(const ConvexSolid& solid) const { return solid.bounds; }
  Bounds operator()(const Ground& ground) const {
    const glm::dvec3 reach(ground.half_size, amplitude_of(ground));
    return {-reach, reach};
  }
};

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

std::optional<double> intersect(const Shape& shape, const Ray& ray) {
  return std::visit([&](const auto& any) { return intersect_shape(any, ray); }, shape);
}

SurfacePoint surface_at(const Shape& shape, const glm::dvec3& position) {
  return std::visit([&](const auto& any) { return surface_of(any, position); }, shape);
}

Bounds bounds_of(const Shape& shape) {
  return std::visit(BoundsOf{}, shape);
}

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
