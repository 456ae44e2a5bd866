// SPDX-License-Identifier: MIT
#include "renderer/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/color.h"
#include "octree/spacing.h"
#include "surface/packed_surface.h"

namespace alidade::renderer {
namespace {

// A kept normal in 32 bits: one for "computed", 7 for trust, 12 + 12 for the normal.
constexpr double k_trust_steps = 127.0, k_side_steps = 4094.0;

std::uint32_t pack(const LocalPlane& value) {
  const glm::uvec2 normal = pack_normal(value.normal, k_side_steps);
  return 0x80000000u | static_cast<std::uint32_t>(value.trust * k_trust_steps + 0.5) << 24 | normal.x << 12 |
         normal.y;
}

LocalPlane unpack(std::uint32_t packed) {
  return {.normal = unpack_normal({packed >> 12 & 0xfffu, packed & 0xfffu}, k_side_steps),
          .trust = (packed >> 24 & 0x7fu) / k_trust_steps};
}

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

/// What a ray that leaves a model does not meet of it: rounding of coordinates and of shapes.
constexpr double k_model_clearance = 1e-5;  // metres

double intersect(const Model& model, const Ray& ray, bool own, bool /*inward*/) {
  const auto hit =
      model.surfaces->nearest({ray.origin, ray.direction, own ? k_model_clearance : 0.0, k_none});
  return hit ? hit->t : k_none;
}

/// Whether a ray meets an object before t = reach.
template <class Object>
bool blocks(const Object& object, const Ray& ray, double reach, bool own, bool inward) {
  return intersect(object, ray, own, inward) < reach;
}
bool blocks(const Model& model, const Ray& ray, double reach, bool own, bool /*inward*/) {
  return model.surfaces->occluded(
      {ray.origin, ray.direction, own ? k_model_clearance : 0.0, std::nextafter(reach, -k_none)});
}

Surface on_sphere(const Ray& ray, double t, const glm::dvec3& center, double radius) {
  Surface surface;
  surface.normal = glm::normalize(ray.origin + t * ray.direction - center);
  // Put back on the sphere: a distant camera has left some rounding in t.
  surface.position = surface.ray_origin = center + radius * surface.normal;
  return surface;
}

/// t: that of the surfaces' answer to this ray.
Surface on_model(const Ray& ray, double t, const Model& model) {
  constexpr double k_slack = 1e-9;  // nothing is nearer
  const auto hit =
      model.surfaces->nearest({ray.origin, ray.direction, std::max(t - k_slack, 0.0), t + k_slack});
  Surface surface{.position = ray.origin + t * ray.direction, .material = &model.material};
  surface.ray_origin = surface.position;
  surface.normal = hit ? hit->normal : -ray.direction;
  if (hit) surface.color = glm::min(hit->color, Rgb(k_brightest_point));
  return surface;
}

/// Display value of each world axis: half of it, around middle grey, towards the viewer.
Color16 normal_color(const Ray& ray, const glm::dvec3& normal) {
  const glm::dvec3 facing = glm::dot(normal, ray.direction) > 0.0 ? -normal : normal;
  return image::to_color16(0.5 + 0.5 * facing);
}

}  // namespace

SmoothNormals::SmoothNormals(const Octree& octree) : octree_(&octree), kept_(octree.size()) {}

LocalPlane SmoothNormals::at(std::uint64_t point_id, const glm::dvec3& position, double reach) const {
  std::atomic<std::uint32_t>& kept = kept_[point_id];
  std::uint32_t packed = kept.load(std::memory_order_relaxed);
  if (packed == 0) {
    // Two threads may both do this; they get the same.
    packed = pack(local_plane(*octree_, position, reach));
    kept.store(packed, std::memory_order_relaxed);
  }
  return unpack(packed);
}

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
  for (std::size_t index = 0; index < scene.objects.size(); ++index) {
    const auto* model = std::get_if<Model>(&scene.objects[index]);
    if (model == nullptr || model->surfaces != nullptr) continue;
    throw Error({.file = model->mesh ? model->mesh->file.string() : "",
                 .problem = fmt::format("object {} has no surfaces", index),
                 .expected = "a model with surfaces: read its mesh before"});
  }
  if (cloud == nullptr || cloud->octree.size() == 0) return;
  const CloudSettings settings = scene.cloud.value_or(CloudSettings{});
  cloud_ = CloudGeometry{
      .octree = &cloud->octree,
      .colors = cloud->point_colors(),
      .shows_normals = cloud->color.by == image::PointColor::normal,
      .query = {.radius = cloud->radius,
                .measure = settings.hits == HitMode::entry ? Measure::entry : Measure::t,
                .entry_min = smallest_entry(cloud->octree.bounds(), cloud->radius),
                .max_level = settings.max_level < k_max_level ? settings.max_level : k_all_levels},
      .surfaces = &cloud->surfaces,
      .material = settings.material,
  };
  if (cloud->spacing_factor > 0.0) {
    cloud_->own_radii = SurfaceQuery{.radius = cloud->radius,
                                     .spacing_factor = cloud->spacing_factor,
                                     .measure = cloud_->query.measure,
                                     .entry_min = cloud_->query.entry_min};
  }
  // The cloud of a preview has no surfaces yet.
  if (settings.shape != PointShape::sphere && cloud->surfaces.has_discs()) {
    discs_.emplace(*cloud, settings.shape == PointShape::blend);
  } else if (settings.normals == NormalMode::smooth &&
             !std::holds_alternative<Dielectric>(settings.material)) {
    smooth_normals_.emplace(cloud->octree);
  }
  linear_.resize(65536);
  for (int value = 0; value < 65536; ++value) {
    linear_[value] = std::min(static_cast<float>(linear_from_srgb(value / 65535.0)), k_brightest_point);
  }
}

Intersection World::nearest_object(const Ray& ray, const RayOrigin& ray_origin) const {
  Intersection best;
  for (std::size_t index = 0; index < objects_->size(); ++index) {
    const double t = std::visit(
        [&](const auto& object) {
          return intersect(object, ray, ray_origin.is_object(index), ray_origin.inward);
        },
        (*objects_)[index]);
    if (t < best.t) best = {.t = t, .index = index};
  }
  return best;
}

bool World::any_object(const Ray& ray, const RayOrigin& ray_origin, double reach) const {
  for (std::size_t index = 0; index < objects_->size(); ++index) {
    const auto is_met = [&](const auto& object) {
      return blocks(object, ray, reach, ray_origin.is_object(index), ray_origin.inward);
    };
    if (std::visit(is_met, (*objects_)[index])) return true;
  }
  return false;
}

std::optional<Intersection> World::nearest(const Ray& ray, const RayOrigin& ray_origin) const {
  std::optional<Intersection> met;
  nearest({&ray, 1}, {&ray_origin, 1}, {&met, 1});
  return met;
}

void World::nearest(std::span<const Ray> rays, std::span<const RayOrigin> ray_origins,
                    std::span<std::optional<Intersection>> met) const {
  std::vector<Ray> asked;
  std::vector<SheetOrigin> sheets;
  std::vector<std::size_t> numbers;
  if (cloud_) {
    asked.reserve(rays.size());
    numbers.reserve(rays.size());
    if (discs_) sheets.reserve(rays.size());
  }
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Intersection best = nearest_object(rays[i], ray_origins[i]);
    if (cloud_ && ray_origins[i].from == RayOrigin::From::point && ray_origins[i].inward && !discs_) {
      const RayOrigin& ray_origin = ray_origins[i];
      const double t = intersect_sphere(rays[i], ray_origin.center, ray_origin.radius, Roots::far_one);
      if (t < best.t) {
        best = {.t = t,
                .on_cloud = true,
                .index = ray_origin.index,
                .center = ray_origin.center,
                .radius = ray_origin.radius,
                .color = color_of(cloud_->colors, ray_origin.index)};
      }
    } else if (cloud_) {
      asked.push_back(interval(rays[i], best.t));
      if (discs_) sheets.push_back(ray_origins[i].sheet);
      numbers.push_back(i);
    }
    met[i] = best.t == k_none ? std::nullopt : std::optional(best);
  }
  if (asked.empty()) return;
  discs_ ? meet_discs(asked, sheets, numbers, met) : meet_spheres(asked, numbers, met);
}

Ray World::interval(const Ray& ray, double t) const {
  if (discs_) return {ray.origin, ray.direction, std::max(cloud_->query.entry_min, ray.t_min), t};
  // The interval of spheres limits projections, which lie up to a radius behind the entry.
  return {ray.origin, ray.direction, std::max(0.0, ray.t_min), t + cloud_->query.radius};
}

void World::meet_spheres(std::span<const Ray> rays, std::span<const std::size_t> numbers,
                         std::span<std::optional<Intersection>> met) const {
  const auto meet = [&](const auto& cloud, const auto& query, const auto& radius_of) {
    std::vector<decltype(closest(cloud, rays.front(), query))> hits(rays.size());
    closest(cloud, rays, query, hits);
    const ColorsAhead colors(cloud_->colors, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      colors.fetch(i);
      const auto& hit = hits[i];
      std::optional<Intersection>& best = met[numbers[i]];
      if (!hit || (best && hit->entry >= best->t)) continue;
      best = {.t = hit->entry,
              .on_cloud = true,
              .index = hit->point_id,
              .center = hit->position,
              .radius = radius_of(*hit),
              .color = colors.of(hit->point_id)};
    }
  };
  if (!cloud_->own_radii)
    return meet(*cloud_->octree, cloud_->query, [&](const Hit&) { return cloud_->query.radius; });
  meet(*cloud_->surfaces, *cloud_->own_radii, [&](const SurfaceHit& hit) {
    return own_radius(*cloud_->own_radii, spacing_at(cloud_->octree->layers(), hit.index));
  });
}

void World::meet_discs(std::span<const Ray> rays, std::span<const SheetOrigin> sheets,
                       std::span<const std::size_t> numbers,
                       std::span<std::optional<Intersection>> met) const {
  std::vector<std::optional<DiscHit>> hits(rays.size());
  discs_->closest(rays, sheets, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::optional<DiscHit>& hit = hits[i];
    std::optional<Intersection>& best = met[numbers[i]];
    if (!hit || (best && hit->t >= best->t)) continue;
    best = {.t = hit->t,
            .on_cloud = true,
            .index = hit->point_id,
            .on_disc = true,
            .sheet = hit->sheet,
            .color = hit->color};
  }
}

void World::trust(std::span<const Ray> rays, std::span<const std::optional<Intersection>> met,
                  std::span<HitTrust> answers) const {
  std::ranges::fill(answers, HitTrust{});
  std::vector<Ray> asked;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!met[i] || !met[i]->on_cloud) continue;
    if (!discs_) {
      answers[i] = {.sigma = met[i]->radius, .support = 1};
      continue;
    }
    asked.push_back(interval(rays[i], k_none));
    numbers.push_back(i);
  }
  std::vector<HitTrust> of_discs(asked.size());
  if (discs_) discs_->trust(asked, of_discs);
  for (std::size_t a = 0; a < asked.size(); ++a) answers[numbers[a]] = of_discs[a];
}

bool World::blocked(const Ray& ray, const RayOrigin& ray_origin) const {
  std::uint8_t answer = 0;
  blocked({&ray, 1}, {&ray_origin, 1}, {&answer, 1});
  return answer != 0;
}

void World::blocked(std::span<const Ray> rays, std::span<const RayOrigin> ray_origins,
                    std::span<std::uint8_t> answers, double reach) const {
  std::vector<Ray> asked;
  std::vector<SheetOrigin> sheets;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    answers[i] = any_object(rays[i], ray_origins[i], reach) ? 1 : 0;
    if (answers[i] != 0 || !cloud_) continue;
    asked.push_back({rays[i].origin, rays[i].direction, discs_ ? cloud_->query.entry_min : 0.0, reach});
    if (discs_) sheets.push_back(ray_origins[i].sheet);
    numbers.push_back(i);
  }
  if (asked.empty()) return;
  std::vector<std::uint8_t> occlusions(asked.size());
  if (discs_)
    discs_->blocked(asked, sheets, occlusions);
  else if (cloud_->own_radii)
    occluded(*cloud_->surfaces, asked, *cloud_->own_radii, occlusions);
  else
    occluded(*cloud_->octree, asked, cloud_->query, occlusions);
  for (std::size_t a = 0; a < asked.size(); ++a) answers[numbers[a]] = occlusions[a];
}

void World::smooth(const Ray& ray, const Intersection& intersection, Surface& surface) const {
  const LocalPlane found =
      smooth_normals_->at(intersection.index, intersection.center, k_normal_reach * intersection.radius);
  const glm::dvec3 facing = glm::dot(found.normal, ray.direction) > 0.0 ? -found.normal : found.normal;
  const double height = glm::dot(surface.position - intersection.center, facing);
  const double lift = k_departure_height * intersection.radius - height;
  surface.ray_origin += found.trust * lift * facing;
  // Both face the ray, and so does their mean.
  surface.normal = glm::normalize(glm::mix(surface.normal, facing, found.trust));
}

Surface World::surface_at(const Ray& ray, const Intersection& intersection) const {
  if (intersection.on_disc) {
    const glm::dvec3& normal = intersection.sheet.normal;
    Surface surface{.position = ray.origin + intersection.t * ray.direction, .normal = normal};
    surface.ray_origin = surface.position;
    surface.material = &cloud_->material;
    surface.color = linear(cloud_->shows_normals ? normal_color(ray, normal) : intersection.color);
    return surface;
  }
  if (intersection.on_cloud) {
    Surface surface = on_sphere(ray, intersection.t, intersection.center, intersection.radius);
    surface.material = &cloud_->material;
    if (smooth_normals_) smooth(ray, intersection, surface);
    surface.color = linear(cloud_->shows_normals ? normal_color(ray, surface.normal) : intersection.color);
    return surface;
  }
  const Object& object = (*objects_)[intersection.index];
  if (const auto* sphere = std::get_if<Sphere>(&object)) {
    Surface surface = on_sphere(ray, intersection.t, sphere->center, sphere->radius);
    surface.material = &sphere->material;
    return surface;
  }
  if (const auto* model = std::get_if<Model>(&object)) return on_model(ray, intersection.t, *model);
  const auto& plane = std::get<GroundPlane>(object);
  Surface surface{.position = ray.origin + intersection.t * ray.direction, .material = &plane.material};
  surface.position.z = plane.height;
  surface.ray_origin = surface.position;
  return surface;
}

}  // namespace alidade::renderer
