// SPDX-License-Identifier: MIT
#include "mesh/triangle_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "base/parallel.h"
#include "base/ray_slabs.h"

namespace alidade {
namespace {

/// Triangles in a block, which is a leaf of the tree.
constexpr std::uint32_t k_block = 4;

/// Each level halves the ranges, and there are fewer than 2^32 triangles.
constexpr int k_most_levels = 32;

using Box = std::array<glm::vec3, 2>;

/// The nearest float of the value on the side of `towards`, which is infinite.
float rounded(double value, float towards) {
  const auto nearest = static_cast<float>(value);
  const bool is_outside = towards < 0.0f ? nearest <= value : nearest >= value;
  return is_outside ? nearest : std::nextafter(nearest, towards);
}

}  // namespace

/// A ray on its walk through the tree, in coordinates relative to the middle of the mesh.
class TriangleTree::Walk {
 public:
  Walk(const Ray& ray, const glm::dvec3& origin)
      : t_min(ray.t_min), t_max(ray.t_max), slabs_(origin, ray.direction) {
    const glm::dvec3& direction = ray.direction;
    for (int axis = 0; axis < 3; ++axis)
      if (std::fabs(direction[axis]) > std::fabs(direction[z_])) z_ = axis;
    x_ = (z_ + 1) % 3;
    y_ = (x_ + 1) % 3;
    shear_ = glm::dvec3(direction[x_], direction[y_], 1.0) / direction[z_];
  }

  /// The stretch within a box.
  template <class Vector>
  Stretch within(const Vector& low, const Vector& high) const {
    Stretch stretch;
    for (int axis = 0; axis < 3; ++axis) stretch.cut(slabs_.between(axis, low[axis], high[axis]));
    return stretch;
  }

  /// The stretch within a node's box and [t_min, t_max].
  Stretch clipped(const Box& box) const {
    Stretch stretch = within(box[0], box[1]);
    stretch.cut({t_min, t_max});
    return stretch;
  }

  /// Where the ray meets a triangle, as t and the weights of a, b, c; empty if it misses the triangle or lies
  /// in its plane. The test of an edge has the same value for both triangles, so that no ray passes between
  /// them. Source: Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, JCGT 2(1), 2013.
  std::optional<std::pair<double, std::array<double, 3>>> meet(const glm::dvec3& a, const glm::dvec3& b,
                                                               const glm::dvec3& c) const {
    const glm::dvec3 from_a = sheared(a), from_b = sheared(b), from_c = sheared(c);
    const double u = from_c.x * from_b.y - from_c.y * from_b.x;
    const double v = from_a.x * from_c.y - from_a.y * from_c.x;
    const double w = from_b.x * from_a.y - from_b.y * from_a.x;
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return std::nullopt;
    const double sum = u + v + w;
    if (sum == 0.0) return std::nullopt;
    const std::array<double, 3> weights{u / sum, v / sum, w / sum};
    return std::pair(weights[0] * from_a.z + weights[1] * from_b.z + weights[2] * from_c.z, weights);
  }

  double t_min, t_max;  ///< t_max shrinks to the best hit

 private:
  /// A vertex relative to the ray: x and y across it, z along it in units of t.
  glm::dvec3 sheared(const glm::dvec3& vertex) const {
    const glm::dvec3 offset = vertex - slabs_.origin();
    return {offset[x_] - shear_.x * offset[z_], offset[y_] - shear_.y * offset[z_], shear_.z * offset[z_]};
  }

  RaySlabs slabs_;
  glm::dvec3 shear_{0.0};
  int x_ = 0, y_ = 0, z_ = 0;
};

/// Builds the tree: sorts the triangles so that each range of blocks is halved along the longest side of the
/// box of their centroids.
class TriangleTree::Build {
 public:
  Build(TriangleTree& tree, const Progress& progress)
      : tree_(tree), progress_(progress, tree.triangles_.size()), items_(tree.triangles_.size()) {
    in_parallel(items_.size(), 4096, [&](std::size_t i) {
      const TriangleMesh::Triangle& triangle = tree_.triangles_[i];
      const glm::dvec3 sum =
          tree_.vertices_[triangle[0]] + tree_.vertices_[triangle[1]] + tree_.vertices_[triangle[2]];
      items_[i] = {glm::vec3(sum), static_cast<std::uint32_t>(i)};
    });
  }

  void run() {
    const auto blocks = static_cast<std::uint32_t>((std::uint64_t{items_.size()} + k_block - 1) / k_block);
    tree_.nodes_.resize(blocks);
    // Block 0 begins no second half: the first box of its node is that of all triangles.
    tree_.nodes_[0].boxes[0] = build_task(0, blocks);
    std::vector<TriangleMesh::Triangle> sorted(items_.size());
    tree_.numbers_.resize(items_.size());
    in_parallel(items_.size(), 4096, [&](std::size_t i) {
      sorted[i] = tree_.triangles_[items_[i].number];
      tree_.numbers_[i] = items_[i].number;
    });
    tree_.triangles_ = std::move(sorted);
  }

 private:
  static constexpr std::uint32_t k_blocks_of_a_task = 1024;

  struct Item {
    glm::vec3 corner_sum{0.0f};  ///< three times the centroid
    std::uint32_t number = 0;    ///< in the mesh
  };

  std::size_t first_of(std::uint32_t block) const {
    return std::min(std::size_t{block} * k_block, items_.size());
  }

  /// Builds the nodes of the blocks [begin, end), and returns their box.
  Box build(std::uint32_t begin, std::uint32_t end) {
    if (end - begin == 1) return box_of_block(begin);
    const std::uint32_t middle = begin + (end - begin) / 2;
    cut(first_of(begin), first_of(middle), first_of(end));
    auto& halves = tree_.nodes_[middle].boxes;
    if (end - begin > k_blocks_of_a_task) {
      tbb::parallel_invoke([&] { halves[0] = build_task(begin, middle); },
                           [&] { halves[1] = build_task(middle, end); });
    } else {
      halves[0] = build(begin, middle);
      halves[1] = build(middle, end);
    }
    return {glm::min(halves[0][0], halves[1][0]), glm::max(halves[0][1], halves[1][1])};
  }

  /// As build(); reports progress if the range is not divided among threads.
  Box build_task(std::uint32_t begin, std::uint32_t end) {
    const Box box = build(begin, end);
    if (end - begin <= k_blocks_of_a_task) progress_.add(first_of(end) - first_of(begin));
    return box;
  }

  /// Sorts items as far as needed: those before `middle` have the smaller centroids along that side.
  void cut(std::size_t begin, std::size_t middle, std::size_t end) {
    glm::vec3 low = items_[begin].corner_sum, high = low;
    for (std::size_t i = begin; i < end; ++i) {
      low = glm::min(low, items_[i].corner_sum);
      high = glm::max(high, items_[i].corner_sum);
    }
    const glm::vec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto at = [&](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [axis](const Item& a, const Item& b) {
      return std::pair(a.corner_sum[axis], a.number) < std::pair(b.corner_sum[axis], b.number);
    });
  }

  Box box_of_block(std::uint32_t block) {
    Bounds bounds;
    for (std::size_t i = first_of(block); i < first_of(block + 1); ++i)
      for (const std::uint32_t vertex : tree_.triangles_[items_[i].number])
        bounds.grow(tree_.vertices_[vertex]);
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      constexpr float k_far = std::numeric_limits<float>::infinity();
      box[0][axis] = rounded(bounds.min[axis] - tree_.slack_, -k_far);
      box[1][axis] = rounded(bounds.max[axis] + tree_.slack_, k_far);
    }
    return box;
  }

  TriangleTree& tree_;
  JoinedProgress progress_;
  std::vector<Item> items_;
};

TriangleTree::TriangleTree(TriangleMesh mesh, const Progress& progress)
    : vertices_(std::move(mesh.vertices)),
      triangles_(std::move(mesh.triangles)),
      vertex_colors_(std::move(mesh.vertex_colors)),
      triangle_colors_(std::move(mesh.triangle_colors)) {
  for (const TriangleMesh::Triangle& triangle : triangles_)
    for (const std::uint32_t vertex : triangle) bounds_.grow(vertices_[vertex]);
  middle_ = bounds_.center();
  for (glm::dvec3& vertex : vertices_) vertex -= middle_;
  // Rays must not miss a flat box at a corner because its sides are rounded.
  slack_ = 0x1p-40 * length_of(bounds_.size());
  Build(*this, progress).run();
}

TriangleTree::Walk TriangleTree::walk_of(const Ray& ray) const {
  return {ray, ray.origin - middle_};
}

/// The hit of a triangle, without its normal; empty if the ray misses it or t is not in [t_min, t_max]. t is
/// clamped to the triangle's box, because rounding may move it outside if the ray grazes the plane.
std::optional<TriangleHit> TriangleTree::meet(const Walk& walk, std::uint32_t slot) const {
  const TriangleMesh::Triangle& triangle = triangles_[slot];
  const glm::dvec3 &a = vertices_[triangle[0]], &b = vertices_[triangle[1]], &c = vertices_[triangle[2]];
  const auto met = walk.meet(a, b, c);
  if (!met) return std::nullopt;
  const Stretch stretch =
      walk.within(glm::min(a, glm::min(b, c)) - slack_, glm::max(a, glm::max(b, c)) + slack_);
  const double t = std::min(std::max(met->first, stretch.begin), stretch.end);
  if (stretch.empty() || !(t >= walk.t_min && t <= walk.t_max)) return std::nullopt;
  return TriangleHit{.t = t, .triangle = numbers_[slot], .vertices = triangle, .weights = met->second};
}

/// As meet(); empty also if `counts` rejects the hit.
std::optional<TriangleHit> TriangleTree::meet(const Walk& walk, std::uint32_t slot, const Ray& ray,
                                              const TriangleFilter& counts) const {
  std::optional<TriangleHit> hit = meet(walk, slot);
  if (hit && counts && !counts(finished(ray, *hit))) hit.reset();
  return hit;
}

/// The hit with its normal.
TriangleHit TriangleTree::finished(const Ray& ray, TriangleHit hit) const {
  const glm::dvec3& a = vertices_[hit.vertices[0]];
  const glm::dvec3 normal = glm::cross(vertices_[hit.vertices[1]] - a, vertices_[hit.vertices[2]] - a);
  // Rounding the vertices relative to the middle may leave a sliver without area.
  hit.normal = normal == glm::dvec3(0.0) ? -ray.direction : unit_direction(normal);
  if (glm::dot(hit.normal, ray.direction) > 0.0) hit.normal = -hit.normal;
  return hit;
}

/// Visits the slots of all blocks whose boxes the ray meets, the nearer half of a range first, until
/// visit(slot) returns true.
template <class Visit>
void TriangleTree::for_slots(Walk& walk, const Visit& visit) const {
  struct Range {
    std::uint32_t begin, end;
    double entry;
  };
  const Stretch all = walk.clipped(nodes_[0].boxes[0]);
  if (all.empty()) return;
  std::array<Range, k_most_levels + 1> waiting;
  int count = 0;
  waiting[count++] = {0, static_cast<std::uint32_t>(nodes_.size()), all.begin};
  while (count > 0) {
    Range range = waiting[--count];
    // Also if it begins at t_max: a triangle at an equal t may have a smaller number.
    bool is_met = range.entry <= walk.t_max;
    while (is_met && range.end - range.begin > 1) {
      const std::uint32_t middle = range.begin + (range.end - range.begin) / 2;
      const Node& node = nodes_[middle];
      const Stretch first = walk.clipped(node.boxes[0]), second = walk.clipped(node.boxes[1]);
      const bool meets_first = !first.empty(), meets_second = !second.empty();
      const Range first_half{range.begin, middle, first.begin}, second_half{middle, range.end, second.begin};
      const bool first_is_nearer = first.begin <= second.begin;
      if (meets_first && meets_second) waiting[count++] = first_is_nearer ? second_half : first_half;
      is_met = meets_first || meets_second;
      range = meets_first && (!meets_second || first_is_nearer) ? first_half : second_half;
    }
    if (!is_met) continue;
    const std::uint64_t begin = std::uint64_t{range.begin} * k_block;
    const std::uint64_t end = std::min<std::uint64_t>(begin + k_block, triangles_.size());
    for (std::uint64_t slot = begin; slot < end; ++slot)
      if (visit(static_cast<std::uint32_t>(slot))) return;
  }
}

std::optional<TriangleHit> TriangleTree::closest(const Ray& ray, const TriangleFilter& counts) const {
  Walk walk = walk_of(ray);
  std::optional<TriangleHit> best;
  for_slots(walk, [&](std::uint32_t slot) {
    const auto hit = meet(walk, slot, ray, counts);
    if (hit && (!best || std::pair(hit->t, hit->triangle) < std::pair(best->t, best->triangle))) {
      best = hit;
      walk.t_max = hit->t;
    }
    return false;
  });
  if (best) best = finished(ray, *best);
  return best;
}

std::optional<Surfaces::Hit> TriangleTree::nearest(const Ray& ray) const {
  const std::optional<TriangleHit> met = closest(ray);
  if (!met) return std::nullopt;
  Hit hit{.t = met->t, .normal = met->normal};
  hit.color = color(*met).value_or(hit.color);
  return hit;
}

bool TriangleTree::occluded(const Ray& ray, const TriangleFilter& counts) const {
  Walk walk = walk_of(ray);
  bool is_met = false;
  for_slots(walk, [&](std::uint32_t slot) { return is_met = meet(walk, slot, ray, counts).has_value(); });
  return is_met;
}

bool TriangleTree::any(const std::function<bool(const Bounds&)>& box,
                       const std::function<bool(const std::array<glm::dvec3, 3>&)>& triangle) const {
  const auto accepts = [&](const Box& relative) {
    return box({middle_ + glm::dvec3(relative[0]), middle_ + glm::dvec3(relative[1])});
  };
  const auto accepts_any_of_block = [&](std::uint32_t block) {
    const std::size_t begin = std::size_t{block} * k_block;
    for (std::size_t i = begin; i < std::min(begin + k_block, triangles_.size()); ++i) {
      const auto& [a, b, c] = triangles_[i];
      if (triangle({middle_ + vertices_[a], middle_ + vertices_[b], middle_ + vertices_[c]})) return true;
    }
    return false;
  };
  std::array<std::array<std::uint32_t, 2>, k_most_levels + 1> waiting;
  int count = 0;
  if (accepts(nodes_[0].boxes[0])) waiting[count++] = {0, static_cast<std::uint32_t>(nodes_.size())};
  while (count > 0) {
    const auto [begin, end] = waiting[--count];
    if (end - begin == 1) {
      if (accepts_any_of_block(begin)) return true;
      continue;
    }
    const std::uint32_t middle = begin + (end - begin) / 2;
    if (accepts(nodes_[middle].boxes[1])) waiting[count++] = {middle, end};
    if (accepts(nodes_[middle].boxes[0])) waiting[count++] = {begin, middle};
  }
  return false;
}

std::optional<Rgb> TriangleTree::color(const TriangleHit& hit) const {
  if (!triangle_colors_.empty()) return triangle_colors_[hit.triangle];
  if (vertex_colors_.empty()) return std::nullopt;
  Rgb color(0.0f);
  for (std::size_t i = 0; i < 3; ++i)
    color += static_cast<float>(hit.weights[i]) * vertex_colors_[hit.vertices[i]];
  return color;
}

}  // namespace alidade
