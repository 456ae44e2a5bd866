// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <type_traits>

#include "octree/candidate.h"
#include "octree/octree.h"
#include "octree/path_index.h"
#include "octree/query.h"
#include "octree/simd/first_answers.h"
#include "octree/tree_query.h"
#include "octree/tree_walk.h"

namespace alidade {

/// An octree as tree_query.h walks it: inner nodes by their frames, leaves as nodes of their own.
class OctreeTree {
 public:
  struct Node {
    Bounds bounds;
    bool inner = true;
    Frame frame{};  ///< of an inner node
    Leaf leaf{};    ///< otherwise
  };

  /// Of a layered octree only the levels 0 to max_level; of points at one position, as a rule, only the
  /// first k.
  explicit OctreeTree(const TreeView& view, int max_level = k_all_levels, std::size_t k = k_all)
      : view_(view), max_level_(max_level), k_(k) {}

  bool empty() const { return view_.node_count == 0; }
  Node root() const { return {.bounds = view_.bounds, .frame = root_frame(view_)}; }
  const Bounds& bounds(const Node& node) const { return node.bounds; }

  template <class Visit>
  void for_each_point(const Node& node, const Visit& visit) const {
    if (node.inner) return;
    for (std::uint32_t i = 0; i < node.leaf.count; ++i) {
      const std::uint32_t index = node.leaf.first + i;
      if (!visit(point_id(view_, index), to_world(view_.lattice, position_of(view_, node.leaf, i)))) return;
    }
  }

  template <class Visit>
  void for_each_child(const Node& node, const Visit& visit) const {
    if (!node.inner) return;
    const bool deeper = node.frame.depth < max_level_;
    const bool skips_equal = k_ != k_all && node.frame.level == k_min_frame_level;
    const unsigned skipped = skips_equal ? simd::slots_after_k_equal(view_, node.frame, k_) : 0;
    for (int slot = 0; slot < k_node_width; ++slot) {
      if ((skipped >> slot & 1u) != 0) continue;
      const std::uint8_t kind = view_.nodes[node.frame.node].kind[slot];
      if (is_inner(kind)) {
        if (!deeper) continue;
        visit(Node{.bounds = child_bounds(view_, node.frame, slot),
                   .frame = child_frame(view_, node.frame, slot)});
      } else if (is_leaf(kind)) {
        visit(Node{.bounds = child_bounds(view_, node.frame, slot),
                   .inner = false,
                   .leaf = child_leaf(view_, node.frame, slot)});
      }
    }
  }

 private:
  const TreeView& view_;
  int max_level_;
  std::size_t k_;
};

// The targets of octree/query.h as tree_query.h takes them: how near, where and in which order the points of
// a box can be. Each keeps references to target and query, which must outlive it, and takes them as checked.

/// What targets have in common: one point is decided and ordered by octree/candidate.h.
template <TargetGeometry T>
class TargetOn {
 public:
  using Answer = AnswerOf<T>;

  TargetOn(const T& target, const QueryOf<T>& query, std::size_t query_index = 0)
      : target_(target), query_(query), query_index_(query_index) {}

  std::optional<Answer> evaluate(const glm::dvec3& position, std::uint64_t point_id) const {
    return alidade::evaluate(target_, query_, position, point_id, query_index_);
  }
  double measured(const Answer& answer) const { return alidade::measured(measure_of(query_), answer); }
  bool precedes(const Answer& a, const Answer& b) const {
    return alidade::precedes(measure_of(query_), a, b);
  }

 protected:
  const T& target_;
  const QueryOf<T>& query_;
  std::size_t query_index_;
};

/// A ray or a cone: a limit on the distance to a line.
template <LineGeometry T>
class AlongTarget : public TargetOn<T> {
 public:
  using TargetOn<T>::TargetOn;

  Reach reach(const Bounds& box, DistanceBound bound) const {
    const RayReach projected = project(line(), box);
    if (bound == DistanceBound::none) return {0.0, projected.t};
    if (bound == DistanceBound::sphere) return {sphere_distance(line(), box), projected.t};
    return {projected.distance.low, projected.t};
  }
  bool too_far(const Reach& reach) const { return reach.distance > widest(reach); }
  bool outside_interval(const Reach& reach) const {
    // A sphere is never entered behind the projection of its centre.
    if constexpr (std::is_same_v<T, Ray>)
      if (reach.t.high < this->query_.entry_min) return true;
    return reach.t.low > line().t_max || reach.t.high < line().t_min;
  }
  double least_measure(const Reach& reach) const {
    if (this->query_.measure == Measure::distance) return reach.distance;
    if (this->query_.measure == Measure::t) return reach.t.low;
    return entry({reach.t.low, reach.distance}, widest(reach));
  }

 private:
  const Ray& line() const {
    if constexpr (std::is_same_v<T, Ray>)
      return this->target_;
    else
      return this->target_.axis;
  }

  /// The limit where it is widest among the points in reach. NaN where it is unknown.
  double widest(const Reach& reach) const {
    if constexpr (std::is_same_v<T, Ray>)
      return this->query_.radius;
    else
      return this->target_.limit(reach.t.high > line().t_max ? line().t_max : reach.t.high);
  }
};

using RayTarget = AlongTarget<Ray>;
using ConeTarget = AlongTarget<Cone>;

class PathTarget : public TargetOn<Path> {
 public:
  PathTarget(const Path& path, const PathQuery& query, std::size_t query_index = 0)
      : TargetOn(path, query, query_index), index_(path) {}

  std::optional<PathHit> evaluate(const glm::dvec3& position, std::uint64_t point_id) const {
    return alidade::evaluate(index_.project(position), target_.t_min, target_.t_max, query_, position,
                             point_id, query_index_);
  }

  Reach reach(const Bounds& box, DistanceBound bound) const {
    if (bound == DistanceBound::none) return {0.0, index_.reach(box, k_unlimited_radius).t};
    const RayReach projected = index_.reach(box, query_.radius);
    return {projected.distance.low, projected.t};
  }
  bool too_far(const Reach& reach) const { return reach.distance > query_.radius; }
  bool outside_interval(const Reach& reach) const {
    return reach.t.low > target_.t_max || reach.t.high < target_.t_min;
  }
  double least_measure(const Reach& reach) const {
    return query_.measure == Measure::distance ? reach.distance : reach.t.low;
  }

 private:
  PathIndex index_;
};

class HalfSpacesTarget : public TargetOn<HalfSpaces> {
 public:
  using TargetOn::TargetOn;

  /// t: signed distance to the first plane, which orders. Distance: how far outside of the others.
  Reach reach(const Bounds& box, DistanceBound bound) const {
    Reach reach{0.0, {0.0, 0.0}};
    for (std::size_t i = 0; i < target_.planes.size(); ++i) {
      const Interval side = signed_distance(target_.planes[i], box);
      if (i == 0) reach.t = side;
      if (i > 0 && bound != DistanceBound::none) reach.distance = std::max(reach.distance, -side.high);
    }
    return reach;
  }
  bool too_far(const Reach& reach) const { return reach.distance > 0.0; }
  bool outside_interval(const Reach& reach) const { return reach.t.high < 0.0; }
  double least_measure(const Reach& reach) const { return reach.t.low; }
};

class BoxTarget : public TargetOn<Bounds> {
 public:
  using TargetOn::TargetOn;

  /// Distance: 1 if the boxes have no point in common, otherwise 0.
  Reach reach(const Bounds& box, DistanceBound bound) const {
    bool apart = false;
    for (int axis = 0; axis < 3; ++axis)
      apart = apart || box.min[axis] > target_.max[axis] || box.max[axis] < target_.min[axis];
    return {apart && bound != DistanceBound::none ? 1.0 : 0.0, {0.0, 0.0}};
  }
  bool too_far(const Reach& reach) const { return reach.distance > 0.0; }
  bool outside_interval(const Reach&) const { return false; }
  double least_measure(const Reach&) const { return 0.0; }
};

class PointTarget : public TargetOn<glm::dvec3> {
 public:
  using TargetOn::TargetOn;

  Reach reach(const Bounds& box, DistanceBound bound) const {
    return {bound == DistanceBound::none ? 0.0 : distance(target_, box).low, {0.0, 0.0}};
  }
  bool too_far(const Reach& reach) const { return reach.distance > query_.radius; }
  bool outside_interval(const Reach&) const { return false; }
  double least_measure(const Reach& reach) const { return reach.distance; }
};

// clang-format off
template <TargetGeometry T> struct TreeTarget;
template <> struct TreeTarget<Ray> : std::type_identity<RayTarget> {};
template <> struct TreeTarget<Cone> : std::type_identity<ConeTarget> {};
template <> struct TreeTarget<Path> : std::type_identity<PathTarget> {};
template <> struct TreeTarget<HalfSpaces> : std::type_identity<HalfSpacesTarget> {};
template <> struct TreeTarget<Bounds> : std::type_identity<BoxTarget> {};
template <> struct TreeTarget<glm::dvec3> : std::type_identity<PointTarget> {};
// clang-format on

template <TargetGeometry T>
typename TreeTarget<T>::type make_target(const T& target, const QueryOf<T>& query, std::size_t query_index) {
  return {target, query, query_index};
}

/// Calls use(tree, target) with an octree and a target as Algorithm 1 (octree/tree_query.h) takes them for
/// this query. k: no more answers are of interest.
template <class Target, class Query, class Use>
auto with_tree_target(const TreeView& view, const Target& target, const Query& query, std::size_t query_index,
                      const Use& use, std::size_t k = k_all) {
  // Without a filter, those of the lowest ids come first, and they are stored first.
  const bool takes_all = !query.filter && query.max_level == k_all_levels;
  return use(OctreeTree(view, query.max_level, takes_all ? k : k_all),
             make_target(target, query, query_index));
}

}  // namespace alidade
