// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "base/bounds.h"
#include "base/surfaces.h"
#include "simulation/finish.h"
#include "simulation/shapes.h"

namespace alidade::simulation {

/// A bounding-volume hierarchy over boxes: finds those that a ray may meet, nearest first. Independent of the
/// shapes in the boxes. Built by the surface area heuristic; immutable.
class ShapeTree {
 public:
  ShapeTree() = default;
  /// One finite, non-empty box per item.
  explicit ShapeTree(std::span<const Bounds> boxes);

  /// Calls visit(item) for every item whose box the ray meets within [t_min, t_max], roughly nearest first,
  /// and some more. visit returns the new t_max, not larger than before; a value below t_min ends the walk.
  template <typename Visit>
  void walk(const Ray& ray, Visit&& visit) const;

 private:
  static constexpr int k_deepest = 60;  ///< levels below the root, kept by the builder

  /// Either two children, at first and first + 1, or `count` > 0 entries of items_ from `first`. Faces are
  /// rounded outwards.
  struct Node {
    float faces[2][3];  ///< min, max
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };

  struct Builder;

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> items_;
};

template <typename Visit>
void ShapeTree::walk(const Ray& ray, Visit&& visit) const {
  if (nodes_.empty()) return;
  // A level direction divides by a tiny number instead of zero: faces then lie far away on their proper side,
  // and the boxes' outward rounding covers the difference.
  constexpr double k_tiny = 1e-200;
  const auto reciprocal = [&](double component) {
    return 1.0 / (component < 0.0 ? std::min(component, -k_tiny) : std::max(component, k_tiny));
  };
  const std::array<double, 3> inverse{reciprocal(ray.direction.x), reciprocal(ray.direction.y),
                                      reciprocal(ray.direction.z)};
  const std::array<int, 3> near{inverse[0] < 0.0, inverse[1] < 0.0, inverse[2] < 0.0};
  double t_max = ray.t_max;
  // The box is left out only if it is missed by more than any rounding here.
  constexpr double k_slack = 1.0 + 0x1p-48;
  const auto entrance = [&](const Node& node, double& enter) {
    double exit = t_max;
    enter = ray.t_min;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = (node.faces[near[axis]][axis] - ray.origin[axis]) * inverse[axis];
      const double high = (node.faces[1 - near[axis]][axis] - ray.origin[axis]) * inverse[axis];
      enter = std::max(enter, low);
      exit = std::min(exit, high);
    }
    return enter <= exit * k_slack;
  };

  struct Waiting {
    std::uint32_t node;
    double enter;
  };
  std::array<Waiting, k_deepest + 2> stack;
  int waiting = 0;
  double enter = 0.0;
  if (!entrance(nodes_[0], enter)) return;
  stack[waiting++] = {0, enter};
  while (waiting > 0) {
    const Waiting next = stack[--waiting];
    if (next.enter > t_max * k_slack) continue;
    const Node* node = &nodes_[next.node];
    while (node != nullptr && node->count == 0) {
      double enter_a = 0.0, enter_b = 0.0;
      const std::uint32_t a = node->first, b = node->first + 1;
      const bool meets_a = entrance(nodes_[a], enter_a), meets_b = entrance(nodes_[b], enter_b);
      node = nullptr;
      if (meets_a && meets_b) {
        const bool a_first = enter_a <= enter_b;
        stack[waiting++] = a_first ? Waiting{b, enter_b} : Waiting{a, enter_a};
        node = &nodes_[a_first ? a : b];
      } else if (meets_a || meets_b) {
        node = &nodes_[meets_a ? a : b];
      }
    }
    if (node == nullptr) continue;
    for (std::uint32_t i = 0; i < node->count; ++i) {
      t_max = visit(items_[node->first + i]);
      if (t_max < ray.t_min) return;
    }
  }
}

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

/// A site made of exact surfaces: the ground truth for scans, images and visibility. Immutable; safe to use
/// from many threads.
///
///   const Site site = courtyard();
///   if (auto hit = site.closest(make_ray(site.origin() + glm::dvec3(0, 0, 1.7), {0, 1, 0}, 0.0)))
///   use(hit->t);
class Site final : public Surfaces {
 public:
  /// `origin` is the world position of the objects' frame.
  Site(std::vector<SiteObject> objects, const glm::dvec3& origin);

  /// The first surface with max(t_min, 0) <= t <= t_max, from either side; nothing behind the ray's origin is
  /// met. Equal t: the lowest object. Requires a unit direction (make_ray). Cost: about half a microsecond.
  std::optional<SiteHit> closest(const Ray& ray) const;

  /// Whether closest() would find a surface; stops at the first one found.
  bool occluded(const Ray& ray) const override;

  std::optional<Hit> nearest(const Ray& ray) const override;
  const Bounds& bounds() const override { return bounds_; }

  const glm::dvec3& origin() const { return origin_; }
  const std::vector<SiteObject>& objects() const { return objects_; }  ///< in their own frame

 private:
  std::vector<SiteObject> objects_;
  glm::dvec3 origin_;
  Bounds bounds_;
  ShapeTree tree_;
  std::vector<std::uint32_t> tree_objects_;  ///< objects in the tree, by item
  std::vector<std::uint32_t> grounds_;       ///< objects so large that a tree does not help; tried last
};

namespace brute_force {

/// Site::closest() and Site::occluded() by loops over all objects: their definition, for tests.
std::optional<SiteHit> closest(const Site& site, const Ray& ray);
bool occluded(const Site& site, const Ray& ray);

}  // namespace brute_force

}  // namespace alidade::simulation
