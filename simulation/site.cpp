// SPDX-License-Identifier: MIT
#include "simulation/site.h"

#include <glm/geometric.hpp>
#include <utility>

namespace alidade {

namespace {

/// The ray in the objects' frame, from its origin on.
Ray to_local(const Ray& ray, const glm::dvec3& origin) {
  return {ray.origin - origin, ray.direction, std::max(ray.t_min, 0.0), ray.t_max};
}

struct Nearest {
  double t = 0.0;
  std::uint32_t object = 0;
};

/// Takes `object` if it is met before `nearest`, or at the same place and stands before it in the list.
void offer(std::optional<Nearest>& nearest, const SiteObject& object, std::uint32_t index, const Ray& local) {
  Ray shortened = local;
  if (nearest) shortened.t_max = nearest->t;
  const std::optional<double> t = shapes::intersect(object.shape, shortened);
  if (!t) return;
  if (!nearest || *t < nearest->t || (*t == nearest->t && index < nearest->object))
    nearest = Nearest{*t, index};
}

SiteHit describe(const Site& site, const Nearest& nearest, const Ray& ray, const Ray& local) {
  const SiteObject& object = site.objects()[nearest.object];
  const glm::dvec3 position = local.position(nearest.t);
  const shapes::SurfacePoint surface = shapes::surface_at(object.shape, position);
  const bool from_behind = glm::dot(surface.normal, ray.direction) > 0.0;
  return {.t = nearest.t,
          .position = site.origin() + position,
          .normal = from_behind ? -surface.normal : surface.normal,
          .color = color_of(object.finish, surface, position),
          .material = object.finish.material,
          .classification = classification_of(object.finish, surface, position),
          .object = nearest.object};
}

bool is_ground(const SiteObject& object) {
  return std::holds_alternative<shapes::Ground>(object.shape);
}

}  // namespace

Site::Site(std::vector<SiteObject> objects, const glm::dvec3& origin)
    : objects_(std::move(objects)), origin_(origin) {
  std::vector<Bounds> boxes;
  Bounds local;
  for (std::uint32_t index = 0; index < objects_.size(); ++index) {
    const Bounds bounds = shapes::bounds_of(objects_[index].shape);
    local.grow(bounds);
    if (is_ground(objects_[index])) {
      grounds_.push_back(index);
    } else {
      boxes.push_back(bounds);
      tree_objects_.push_back(index);
    }
  }
  if (!local.empty()) bounds_ = {origin_ + local.min, origin_ + local.max};
  tree_ = ShapeTree(boxes);
}

std::optional<SiteHit> Site::closest(const Ray& ray) const {
  const Ray local = to_local(ray, origin_);
  std::optional<Nearest> nearest;
  tree_.walk(local, [&](std::uint32_t item) {
    const std::uint32_t index = tree_objects_[item];
    offer(nearest, objects_[index], index, local);
    return nearest ? nearest->t : local.t_max;
  });
  for (const std::uint32_t index : grounds_) offer(nearest, objects_[index], index, local);
  if (!nearest) return std::nullopt;
  return describe(*this, *nearest, ray, local);
}

bool Site::occluded(const Ray& ray) const {
  const Ray local = to_local(ray, origin_);
  bool found = false;
  tree_.walk(local, [&](std::uint32_t item) {
    found = shapes::intersect(objects_[tree_objects_[item]].shape, local).has_value();
    return found ? -1.0 : local.t_max;
  });
  if (found) return true;
  for (const std::uint32_t index : grounds_)
    if (shapes::intersect(objects_[index].shape, local)) return true;
  return false;
}

namespace brute_force {

std::optional<SiteHit> closest(const Site& site, const Ray& ray) {
  const Ray local = to_local(ray, site.origin());
  std::optional<Nearest> nearest;
  for (std::uint32_t index = 0; index < site.objects().size(); ++index)
    offer(nearest, site.objects()[index], index, local);
  if (!nearest) return std::nullopt;
  return describe(site, *nearest, ray, local);
}

bool occluded(const Site& site, const Ray& ray) {
  return closest(site, ray).has_value();
}

}  // namespace brute_force

}  // namespace alidade
