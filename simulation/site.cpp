// SPDX-License-Identifier: MIT
#include "simulation/site.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <utility>

namespace alidade::simulation {
namespace {

constexpr std::size_t k_leaf_size = 3;
constexpr int k_bin_count = 16;

double half_area(const Bounds& bounds) {
  const glm::dvec3 size = bounds.size();
  return size.x * size.y + size.y * size.z + size.z * size.x;
}

/// A float beyond `value` in the direction of `limit`, with a margin for the rounding of the walk.
float rounded_outwards(double value, float limit) {
  const double margin = 1e-9 + std::fabs(value) * 1e-12;
  const double beyond = limit > 0.0f ? value + margin : value - margin;
  return std::nextafter(static_cast<float>(beyond), limit);
}

/// The ray in the objects' frame, from its origin on.
Ray to_local(const Ray& ray, const glm::dvec3& origin) {
  return {ray.origin - origin, ray.direction, std::max(ray.t_min, 0.0), ray.t_max};
}

struct Nearest {
  double t = 0.0;
  std::uint32_t object = 0;
};

/// Replaces `nearest` by `object` if the ray meets it at a smaller t, or at an equal
/// one and its index is lower.
void offer(std::optional<Nearest>& nearest, const SiteObject& object, std::uint32_t index, const Ray& local) {
  Ray shortened = local;
  if (nearest) shortened.t_max = nearest->t;
  const std::optional<double> t = shapes::intersect(object.shape, shortened);
  if (!t) return;
  if (!nearest || *t < nearest->t || (*t == nearest->t && index < nearest->object))
    nearest = Nearest{*t, index};
}

std::optional<SiteHit> describe(const Site& site, const std::optional<Nearest>& nearest, const Ray& ray,
                                const Ray& local) {
  if (!nearest) return std::nullopt;
  const SiteObject& object = site.objects()[nearest->object];
  const glm::dvec3 position = local.position(nearest->t);
  const shapes::SurfacePoint surface = shapes::surface_at(object.shape, position);
  const bool from_behind = glm::dot(surface.normal, ray.direction) > 0.0;
  return SiteHit{.t = nearest->t,
                 .position = site.origin() + position,
                 .normal = from_behind ? -surface.normal : surface.normal,
                 .color = color_of(object.finish, surface, position),
                 .material = object.finish.material,
                 .classification = classification_of(object.finish, surface, position),
                 .object = nearest->object};
}

}  // namespace

struct ShapeTree::Builder {
  std::span<const Bounds> boxes;
  std::vector<Node>& nodes;
  std::vector<std::uint32_t>& items;

  Bounds bounds_of(std::size_t begin, std::size_t end) const {
    Bounds bounds;
    for (std::size_t i = begin; i < end; ++i) bounds.grow(boxes[items[i]]);
    return bounds;
  }

  /// Sorts the items of a node into two parts and returns where the second begins. Halves if the node is deep
  /// or all centres are equal.
  std::size_t split(std::size_t begin, std::size_t end, int depth) {
    Bounds centers;
    for (std::size_t i = begin; i < end; ++i) centers.grow(boxes[items[i]].center());
    const glm::dvec3 size = centers.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto first = items.begin() + static_cast<std::ptrdiff_t>(begin),
               last = items.begin() + static_cast<std::ptrdiff_t>(end);
    const auto halves = [&] {
      const std::size_t middle = begin + (end - begin) / 2;
      std::nth_element(first, items.begin() + static_cast<std::ptrdiff_t>(middle), last,
                       [&](std::uint32_t a, std::uint32_t b) {
                         const double x = boxes[a].center()[axis], y = boxes[b].center()[axis];
                         return x < y || (x == y && a < b);
                       });
      return middle;
    };
    // There are at most 2^32 items: halves from here on keep within k_deepest.
    constexpr int k_depth_for_halves = k_deepest - 32;
    if (!(size[axis] > 0.0) || depth >= k_depth_for_halves) return halves();

    const auto bin_of = [&](std::uint32_t item) {
      const double bin = (boxes[item].center()[axis] - centers.min[axis]) / size[axis] * k_bin_count;
      return std::min(static_cast<int>(bin), k_bin_count - 1);
    };
    std::array<Bounds, k_bin_count> bins;
    std::array<std::size_t, k_bin_count> counts{};
    for (std::size_t i = begin; i < end; ++i) {
      const int bin = bin_of(items[i]);
      bins[bin].grow(boxes[items[i]]);
      ++counts[bin];
    }
    std::array<double, k_bin_count> cost_above{};
    Bounds above;
    std::size_t count_above = 0;
    for (int bin = k_bin_count - 1; bin > 0; --bin) {
      above.grow(bins[bin]);
      count_above += counts[bin];
      cost_above[bin] = half_area(above) * static_cast<double>(count_above);
    }
    Bounds below;
    std::size_t count_below = 0;
    double lowest = std::numeric_limits<double>::infinity();
    int best = 1;
    for (int bin = 1; bin < k_bin_count; ++bin) {
      below.grow(bins[bin - 1]);
      count_below += counts[bin - 1];
      if (count_below == 0 || count_below == end - begin) continue;
      const double cost = half_area(below) * static_cast<double>(count_below) + cost_above[bin];
      if (cost < lowest) lowest = cost, best = bin;
    }
    const auto middle = std::partition(first, last, [&](std::uint32_t item) { return bin_of(item) < best; });
    return static_cast<std::size_t>(middle - items.begin());
  }

  void build(std::uint32_t index, std::size_t begin, std::size_t end, int depth) {
    const Bounds bounds = bounds_of(begin, end);
    constexpr float k_infinity = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      nodes[index].faces[0][axis] = rounded_outwards(bounds.min[axis], -k_infinity);
      nodes[index].faces[1][axis] = rounded_outwards(bounds.max[axis], k_infinity);
    }
    if (end - begin <= k_leaf_size) {
      nodes[index].first = static_cast<std::uint32_t>(begin);
      nodes[index].count = static_cast<std::uint32_t>(end - begin);
      return;
    }
    const std::size_t middle = split(begin, end, depth);
    const auto children = static_cast<std::uint32_t>(nodes.size());
    nodes.resize(nodes.size() + 2);
    nodes[index].first = children;
    build(children, begin, middle, depth + 1);
    build(children + 1, middle, end, depth + 1);
  }
};

ShapeTree::ShapeTree(std::span<const Bounds> boxes) {
  if (boxes.empty()) return;
  items_.resize(boxes.size());
  std::iota(items_.begin(), items_.end(), 0u);
  nodes_.resize(1);
  Builder{boxes, nodes_, items_}.build(0, 0, boxes.size(), 0);
}

Site::Site(std::vector<SiteObject> objects, const glm::dvec3& origin)
    : objects_(std::move(objects)), origin_(origin) {
  std::vector<Bounds> boxes;
  Bounds local;
  for (std::uint32_t index = 0; index < objects_.size(); ++index) {
    const Bounds bounds = shapes::bounds_of(objects_[index].shape);
    local.grow(bounds);
    if (std::holds_alternative<shapes::Ground>(objects_[index].shape)) {
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
  return describe(*this, nearest, ray, local);
}

std::optional<Surfaces::Hit> Site::nearest(const Ray& ray) const {
  const std::optional<SiteHit> met = closest(ray);
  if (!met) return std::nullopt;
  Hit hit{.t = met->t, .normal = met->normal};
  for (int channel = 0; channel < 3; ++channel)
    hit.color[channel] = static_cast<float>(linear_from_srgb(met->color[channel]));
  return hit;
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
  return describe(site, nearest, ray, local);
}

bool occluded(const Site& site, const Ray& ray) {
  return closest(site, ray).has_value();
}

}  // namespace brute_force

}  // namespace alidade::simulation
