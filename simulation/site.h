// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "base/bounds.h"
#include "base/ray.h"
#include "simulation/finish.h"
#include "simulation/shape_tree.h"
#include "simulation/shapes.h"

namespace alidade {

struct SiteObject {
  shapes::Shape shape;
  Finish finish;
};

/// Where a ray meets a site.
struct SiteHit {
  double t = 0.0;            ///< metres along the ray
  glm::dvec3 position{0.0};  ///< world
  glm::dvec3 normal{0.0};    ///< length 1, towards the side the ray came from
  glm::dvec3 color{0.0};     ///< display-referred (sRGB), 0 .. 1
  SiteMaterial material = SiteMaterial::stone;
  std::uint8_t classification = 1;
  std::uint32_t object = 0;  ///< index in Site::objects()

  bool operator==(const SiteHit&) const = default;
};

/// A place made of exact surfaces: the ground truth for scans, images and visibility. Immutable; safe to ask
/// from many threads.
///
///   const Site site = courtyard();
///   if (auto hit = site.closest(make_ray(site.origin() + glm::dvec3(0, 0, 1.7), {0, 1, 0}, 0.0)))
///   use(hit->t);
class Site {
 public:
  /// `origin` is the world position of the objects' frame.
  Site(std::vector<SiteObject> objects, const glm::dvec3& origin);

  /// The first surface with max(t_min, 0) <= t <= t_max, from either side: nothing lies behind a ray's
  /// origin. Equal t: the lowest object. Requires a unit direction (make_ray). Cost: about half a
  /// microsecond.
  std::optional<SiteHit> closest(const Ray& ray) const;

  /// Whether closest() would answer; stops at the first surface found.
  bool occluded(const Ray& ray) const;

  const glm::dvec3& origin() const { return origin_; }
  const Bounds& bounds() const { return bounds_; }                     ///< world
  const std::vector<SiteObject>& objects() const { return objects_; }  ///< in their own frame

 private:
  std::vector<SiteObject> objects_;
  glm::dvec3 origin_;
  Bounds bounds_;
  ShapeTree tree_;
  std::vector<std::uint32_t> tree_objects_;  ///< objects that are items of the tree
  std::vector<std::uint32_t> grounds_;       ///< objects so large that a tree does not help; tried last
};

namespace brute_force {

/// The same answers by plain loops over all objects: the definition, and the oracle of the tests.
std::optional<SiteHit> closest(const Site& site, const Ray& ray);
bool occluded(const Site& site, const Ray& ray);

}  // namespace brute_force

}  // namespace alidade
