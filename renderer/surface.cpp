// SPDX-License-Identifier: MIT
#include "renderer/surface.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "renderer/deterministic_math.h"

namespace alidade {
namespace {

/// Nothing real reflects all light; an overexposed white point would otherwise light its surroundings for
/// ever.
constexpr float k_brightest_point = 0.95f;

/// Neighbourhood that smooths a normal, in radii of a point.
constexpr double k_normal_reach = 2.5;

/// Height above a smooth surface's points from which rays leave it, in radii: a little above the tops of the
/// spheres.
constexpr double k_departure_height = 1.25;

constexpr double k_none = std::numeric_limits<double>::infinity();

enum class Roots { first_ahead, far_one };

/// Where a ray meets a sphere at t > 0; infinity if nowhere.
/// The discriminant comes from the perpendicular, which keeps its digits when the sphere is far away or
/// large. Source: Haines et al., Precision Improvements for Ray/Sphere Intersection, Ray Tracing Gems, 2019.
double intersect_sphere(const Ray& ray, const glm::dvec3& center, double radius, Roots roots) {
  const glm::dvec3 offset = center - ray.origin;
  const double middle = glm::dot(offset, ray.direction);
  const glm::dvec3 perpendicular = offset - middle * ray.direction;
  const double half_chord_sq = radius * radius - glm::dot(perpendicular, perpendicular);
  if (roots == Roots::far_one) return std::max(0.0, middle + std::sqrt(std::max(0.0, half_chord_sq)));
  if (half_chord_sq < 0.0) return k_none;
  const double half_chord = std::sqrt(half_chord_sq);
  if (middle - half_chord > 0.0) return middle - half_chord;
  return middle + half_chord > 0.0 ? middle + half_chord : k_none;
}

double intersect(const Sphere& sphere, const Ray& ray, bool own, bool inward) {
  if (own && !inward) return k_none;
  return intersect_sphere(ray, sphere.center, sphere.radius, own ? Roots::far_one : Roots::first_ahead);
}

double intersect(const GroundPlane& plane, const Ray& ray, bool own, bool /*inward*/) {
  if (own || ray.direction.z == 0.0) return k_none;
  const double t = (plane.height - ray.origin.z) / ray.direction.z;
  return t > 0.0 ? t : k_none;
}

Surface on_sphere(const Ray& ray, double t, const glm::dvec3& center, double radius) {
  Surface surface;
  surface.normal = glm::normalize(ray.origin + t * ray.direction - center);
  // Put back on the sphere: a distant camera has left some rounding in t.
  surface.position = surface.departure = center + radius * surface.normal;
  return surface;
}

}  // namespace

double smallest_entry(const Bounds& bounds, double radius) {
  double magnitude = 0.0;
  if (!bounds.empty()) {
    for (int axis = 0; axis < 3; ++axis) {
      magnitude = std::max({magnitude, std::fabs(bounds.min[axis]), std::fabs(bounds.max[axis])});
    }
  }
  return 0x1p-48 * (magnitude + radius) + 0x1p-40 * radius;
}

World::World(const Scene& scene, const LoadedCloud* cloud) : objects_(&scene.objects) {
  if (cloud == nullptr || cloud->octree.size() == 0) return;
  const CloudSettings settings = scene.cloud.value_or(CloudSettings{});
  cloud_ = CloudGeometry{
      .octree = &cloud->octree,
      .colors = cloud->point_colors(),
      .query = {.radius = cloud->radius,
                .measure = settings.hits == HitMode::entry ? Measure::entry : Measure::t,
                .entry_min = smallest_entry(cloud->octree.bounds(), cloud->radius),
                .max_level = settings.max_level < k_max_level ? settings.max_level : k_all_levels},
      .material = settings.material,
  };
  if (settings.normals == NormalMode::smooth && !std::holds_alternative<Dielectric>(settings.material)) {
    smooth_normals_.emplace(cloud->octree, k_normal_reach * cloud->radius);
  }
  linear_.resize(65536);
  for (int value = 0; value < 65536; ++value) {
    linear_[value] = std::min(static_cast<float>(linear_from_srgb(value / 65535.0)), k_brightest_point);
  }
}

Intersection World::nearest_object(const Ray& ray, const Departure& departure) const {
  Intersection best;
  for (std::size_t index = 0; index < objects_->size(); ++index) {
    const bool own = departure.from == Departure::From::object && departure.index == index;
    const double t =
        std::visit([&](const auto& object) { return intersect(object, ray, own, departure.inward); },
                   (*objects_)[index]);
    if (t < best.t) best = {.t = t, .index = index};
  }
  return best;
}

std::optional<Intersection> World::nearest(const Ray& ray, const Departure& departure) const {
  Intersection best = nearest_object(ray, departure);
  if (cloud_ && departure.from == Departure::From::point && departure.inward) {
    const double t = intersect_sphere(ray, departure.center, cloud_->query.radius, Roots::far_one);
    if (t < best.t) best = {.t = t, .on_cloud = true, .index = departure.index, .center = departure.center};
  } else if (cloud_) {
    // The interval limits projections, which lie up to a radius behind the place of entry.
    const Ray limited{ray.origin, ray.direction, 0.0, best.t + cloud_->query.radius};
    const std::optional<Hit> hit = closest(*cloud_->octree, limited, cloud_->query);
    if (hit && hit->entry < best.t) {
      best = {.t = hit->entry, .on_cloud = true, .index = hit->point_id, .center = hit->position};
    }
  }
  if (best.t == k_none) return std::nullopt;
  return best;
}

bool World::blocked(const Ray& ray, const Departure& departure) const {
  if (nearest_object(ray, departure).t < k_none) return true;
  if (!cloud_) return false;
  return occluded(*cloud_->octree, Ray{ray.origin, ray.direction, 0.0, k_none}, cloud_->query);
}

void World::smooth(const Ray& ray, const Intersection& intersection, Surface& surface) const {
  const SmoothNormal found = smooth_normals_->at(intersection.index, intersection.center);
  const glm::dvec3 facing = glm::dot(found.normal, ray.direction) > 0.0 ? -found.normal : found.normal;
  const double height = glm::dot(surface.position - intersection.center, facing);
  const double lift = k_departure_height * cloud_->query.radius - height;
  surface.departure += found.trust * lift * facing;
  // Both face the ray, and so does their mean.
  surface.normal = glm::normalize(glm::mix(surface.normal, facing, found.trust));
}

Surface World::surface_at(const Ray& ray, const Intersection& intersection) const {
  if (intersection.on_cloud) {
    Surface surface = on_sphere(ray, intersection.t, intersection.center, cloud_->query.radius);
    const Color16& color = cloud_->colors[intersection.index];
    surface.color = {linear_[color.r], linear_[color.g], linear_[color.b]};
    surface.material = &cloud_->material;
    if (smooth_normals_) smooth(ray, intersection, surface);
    return surface;
  }
  const Object& object = (*objects_)[intersection.index];
  if (const auto* sphere = std::get_if<Sphere>(&object)) {
    Surface surface = on_sphere(ray, intersection.t, sphere->center, sphere->radius);
    surface.material = &sphere->material;
    return surface;
  }
  const auto& plane = std::get<GroundPlane>(object);
  Surface surface{.position = ray.origin + intersection.t * ray.direction, .material = &plane.material};
  surface.position.z = plane.height;
  surface.departure = surface.position;
  return surface;
}

}  // namespace alidade
