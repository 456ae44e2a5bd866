// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <type_traits>

#include "octree/candidate.h"
#include "octree/octree.h"
#include "octree/path_index.h"
#include "octree/query.h"
#include "octree/tree_query.h"
#include "octree/tree_walk.h"

namespace alidade {

/// By what a tree tells its points apart.
enum class PointNaming { id, place };

/// An octree as tree_query.h walks it: inner nodes by their frames, leaves as nodes of their own.
template <PointNaming naming>
class OctreeAsTree {
 public:
  struct Node {
    Bounds bounds;
    bool inner = true;
    Frame frame{};  ///< of an inner node
    Leaf leaf{};    ///< otherwise
  };

  /// Of a layered octree only the levels 0 to max_level.
  explicit OctreeAsTree(const TreeView& view, int max_level = k_all_levels)
      : view_(view), max_level_(max_level) {}

  bool empty() const { return view_.node_count == 0; }
  Node root() const { return {.bounds = view_.bounds, .frame = root_frame(view_)}; }
  const Bounds& bounds(const Node& node) const { return node.bounds; }

  template <class Visit>
  void for_each_point(const Node& node, const Visit& visit) const {
    if (node.inner) return;
    for (std::uint32_t i = 0; i < node.leaf.count; ++i) {
      const std::uint32_t place = node.leaf.place + i;
      if (!visit(naming == PointNaming::place ? place : point_id(view_, place),
                 to_world(view_.lattice, position_of(view_, node.leaf, i))))
        return;
    }
  }

  template <class Visit>
  void for_each_child(const Node& node, const Visit& visit) const {
    if (!node.inner) return;
    const bool deeper = node.frame.depth < max_level_;
    for (int slot = 0; slot < k_node_width; ++slot) {
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
};

using OctreeTree = OctreeAsTree<PointNaming::id>;
/// For targets that ask what is stored by place.
using OctreePlaces = OctreeAsTree<PointNaming::place>;

// The targets of octree/query.h as tree_query.h takes them: how near, where and in which order the points of
// a box can be. Each keeps references to target and query, which must outlive it, and takes them as checked.

class RayTarget {
 public:
  using Answer = Hit;

  RayTarget(const Ray& ray, const RayQuery& query, std::size_t query_index = 0)
      : ray_(ray), query_(query), query_index_(query_index) {}

  std::optional<Hit> evaluate(const glm::dvec3& position, std::uint64_t point_id) const {
    return alidade::evaluate(ray_, query_, position, point_id, query_index_);
  }
  double measured(const Hit& hit) const { return alidade::measured(query_.measure, hit); }
  bool precedes(const Hit& a, const Hit& b) const { return alidade::precedes(query_.measure, a, b); }

  Reach reach(const Bounds& box, DistanceBound bound) const {
    const RayReach projected = project(ray_, box);
    if (bound == DistanceBound::none) return {0.0, projected.t};
    if (bound == DistanceBound::sphere) return {sphere_distance(ray_, box), projected.t};
    return {projected.distance.low, projected.t};
  }
  bool too_far(const Reach& reach) const { return reach.distance > query_.radius; }
  bool outside_interval(const Reach& reach) const {
    // A sphere is never entered behind the projection of its centre.
    return reach.t.low > ray_.t_max || reach.t.high < ray_.t_min || reach.t.high < query_.entry_min;
  }
  double least_measure(const Reach& reach) const {
    if (query_.measure == Measure::distance) return reach.distance;
    if (query_.measure == Measure::t) return reach.t.low;
    return entry({reach.t.low, reach.distance}, query_.radius);
  }

 private:
  const Ray& ray_;
  const RayQuery& query_;
  std::size_t query_index_;
};

/// A ray that meets points with radii of their own (RayQuery::spacing_factor), told by their places.
class OwnRadiusTarget {
 public:
  using Answer = Hit;

  OwnRadiusTarget(const TreeView& tree, const Ray& ray, const RayQuery& query, std::size_t query_index = 0)
      : tree_(tree), ray_(ray), query_(query), query_index_(query_index), widest_(ray, query, query_index) {}

  std::optional<Hit> evaluate(const glm::dvec3& position, std::uint64_t place) const {
    const auto tree_place = static_cast<std::uint32_t>(place);
    return alidade::evaluate(ray_, query_, own_radius(query_, spacing_at(tree_, tree_place)), position,
                             point_id(tree_, tree_place), query_index_);
  }
  double measured(const Hit& hit) const { return widest_.measured(hit); }
  bool precedes(const Hit& a, const Hit& b) const { return widest_.precedes(a, b); }

  // No point's radius is above the query's.
  Reach reach(const Bounds& box, DistanceBound bound) const { return widest_.reach(box, bound); }
  bool too_far(const Reach& reach) const { return widest_.too_far(reach); }
  bool outside_interval(const Reach& reach) const { return widest_.outside_interval(reach); }
  double least_measure(const Reach& reach) const { return widest_.least_measure(reach); }

 private:
  const TreeView& tree_;
  const Ray& ray_;
  const RayQuery& query_;
  std::size_t query_index_;
  RayTarget widest_;
};

class ConeTarget {
 public:
  using Answer = Hit;

  ConeTarget(const Cone& cone, const ConeQuery& query, std::size_t query_index = 0)
      : cone_(cone), query_(query), query_index_(query_index) {}

  std::optional<Hit> evaluate(const glm::dvec3& position, std::uint64_t point_id) const {
    return alidade::evaluate(cone_, query_, position, point_id, query_index_);
  }
  double measured(const Hit& hit) const { return alidade::measured(query_.measure, hit); }
  bool precedes(const Hit& a, const Hit& b) const { return alidade::precedes(query_.measure, a, b); }

  Reach reach(const Bounds& box, DistanceBound bound) const {
    const RayReach projected = project(cone_.axis, box);
    if (bound == DistanceBound::none) return {0.0, projected.t};
    if (bound == DistanceBound::sphere) return {sphere_distance(cone_.axis, box), projected.t};
    return {projected.distance.low, projected.t};
  }
  bool too_far(const Reach& reach) const { return reach.distance > widest(reach); }
  bool outside_interval(const Reach& reach) const {
    return reach.t.low > cone_.axis.t_max || reach.t.high < cone_.axis.t_min;
  }
  double least_measure(const Reach& reach) const {
    if (query_.measure == Measure::distance) return reach.distance;
    if (query_.measure == Measure::t) return reach.t.low;
    return entry({reach.t.low, reach.distance}, widest(reach));
  }

 private:
  /// The cone's limit where it is widest among the points in reach. NaN where nothing is known.
  double widest(const Reach& reach) const {
    return cone_.limit(reach.t.high > cone_.axis.t_max ? cone_.axis.t_max : reach.t.high);
  }

  const Cone& cone_;
  const ConeQuery& query_;
  std::size_t query_index_;
};

class PathTarget {
 public:
  using Answer = PathHit;

  PathTarget(const Path& path, const PathQuery& query, std::size_t query_index = 0)
      : path_(path), index_(path), query_(query), query_index_(query_index) {}

  std::optional<PathHit> evaluate(const glm::dvec3& position, std::uint64_t point_id) const {
    return alidade::evaluate(index_.project(position), path_.t_min, path_.t_max, query_, position, point_id,
                             query_index_);
  }
  double measured(const PathHit& hit) const { return alidade::measured(query_.measure, hit); }
  bool precedes(const PathHit& a, const PathHit& b) const { return alidade::precedes(query_.measure, a, b); }

  Reach reach(const Bounds& box, DistanceBound bound) const {
    if (bound == DistanceBound::none) return {0.0, index_.reach(box, k_unlimited_radius).t};
    const RayReach projected = index_.reach(box, query_.radius);
    return {projected.distance.low, projected.t};
  }
  bool too_far(const Reach& reach) const { return reach.distance > query_.radius; }
  bool outside_interval(const Reach& reach) const {
    return reach.t.low > path_.t_max || reach.t.high < path_.t_min;
  }
  double least_measure(const Reach& reach) const {
    return query_.measure == Measure::distance ? reach.distance : reach.t.low;
  }

 private:
  const Path& path_;
  PathIndex index_;
  const PathQuery& query_;
  std::size_t query_index_;
};

class HalfSpacesTarget {
 public:
  using Answer = PointHit;

  HalfSpacesTarget(const HalfSpaces& region, const PointQuery& query, std::size_t query_index = 0)
      : region_(region), query_(query), query_index_(query_index) {}

  std::optional<PointHit> evaluate(const glm::dvec3& position, std::uint64_t point_id) const {
    return alidade::evaluate(region_, query_, position, point_id, query_index_);
  }
  double measured(const PointHit& hit) const { return hit.distance; }
  bool precedes(const PointHit& a, const PointHit& b) const {
    return alidade::precedes(Measure::distance, a, b);
  }

  /// t: signed distance to the first plane, which orders. Distance: how far outside of the others.
  Reach reach(const Bounds& box, DistanceBound bound) const {
    Reach reach{0.0, {0.0, 0.0}};
    for (std::size_t i = 0; i < region_.planes.size(); ++i) {
      const Interval side = signed_distance(region_.planes[i], box);
      if (i == 0) reach.t = side;
      if (i > 0 && bound != DistanceBound::none) reach.distance = std::max(reach.distance, -side.high);
    }
    return reach;
  }
  bool too_far(const Reach& reach) const { return reach.distance > 0.0; }
  bool outside_interval(const Reach& reach) const { return reach.t.high < 0.0; }
  double least_measure(const Reach& reach) const { return reach.t.low; }

 private:
  const HalfSpaces& region_;
  const PointQuery& query_;
  std::size_t query_index_;
};

class BoxTarget {
 public:
  using Answer = PointHit;

  BoxTarget(const Bounds& box, const PointQuery& query, std::size_t query_index = 0)
      : box_(box), query_(query), query_index_(query_index) {}

  std::optional<PointHit> evaluate(const glm::dvec3& position, std::uint64_t point_id) const {
    return alidade::evaluate(box_, query_, position, point_id, query_index_);
  }
  double measured(const PointHit& hit) const { return hit.distance; }
  bool precedes(const PointHit& a, const PointHit& b) const {
    return alidade::precedes(Measure::distance, a, b);
  }

  /// Distance: 1 if the boxes have no place in common, otherwise 0.
  Reach reach(const Bounds& box, DistanceBound bound) const {
    bool apart = false;
    for (int axis = 0; axis < 3; ++axis)
      apart = apart || box.min[axis] > box_.max[axis] || box.max[axis] < box_.min[axis];
    return {apart && bound != DistanceBound::none ? 1.0 : 0.0, {0.0, 0.0}};
  }
  bool too_far(const Reach& reach) const { return reach.distance > 0.0; }
  bool outside_interval(const Reach&) const { return false; }
  double least_measure(const Reach&) const { return 0.0; }

 private:
  const Bounds& box_;
  const PointQuery& query_;
  std::size_t query_index_;
};

class PointTarget {
 public:
  using Answer = PointHit;

  PointTarget(const glm::dvec3& point, const PointQuery& query, std::size_t query_index = 0)
      : point_(point), query_(query), query_index_(query_index) {}

  std::optional<PointHit> evaluate(const glm::dvec3& position, std::uint64_t point_id) const {
    return alidade::evaluate(point_, query_, position, point_id, query_index_);
  }
  double measured(const PointHit& hit) const { return hit.distance; }
  bool precedes(const PointHit& a, const PointHit& b) const {
    return alidade::precedes(Measure::distance, a, b);
  }

  Reach reach(const Bounds& box, DistanceBound bound) const {
    return {bound == DistanceBound::none ? 0.0 : distance(point_, box).low, {0.0, 0.0}};
  }
  bool too_far(const Reach& reach) const { return reach.distance > query_.radius; }
  bool outside_interval(const Reach&) const { return false; }
  double least_measure(const Reach& reach) const { return reach.distance; }

 private:
  const glm::dvec3& point_;
  const PointQuery& query_;
  std::size_t query_index_;
};

inline RayTarget make_target(const Ray& ray, const RayQuery& query, std::size_t query_index) {
  return {ray, query, query_index};
}
inline ConeTarget make_target(const Cone& cone, const ConeQuery& query, std::size_t query_index) {
  return {cone, query, query_index};
}
inline PathTarget make_target(const Path& path, const PathQuery& query, std::size_t query_index) {
  return {path, query, query_index};
}
inline HalfSpacesTarget make_target(const HalfSpaces& region, const PointQuery& query,
                                    std::size_t query_index) {
  return {region, query, query_index};
}
inline BoxTarget make_target(const Bounds& box, const PointQuery& query, std::size_t query_index) {
  return {box, query, query_index};
}
inline PointTarget make_target(const glm::dvec3& point, const PointQuery& query, std::size_t query_index) {
  return {point, query, query_index};
}

/// Calls use(tree, target) with an octree and a target as Algorithm 1 (octree/tree_query.h) takes them for
/// this query. Points with radii of their own are told by their places.
template <class Target, class Query, class Use>
auto with_tree_target(const TreeView& view, const Target& target, const Query& query, std::size_t query_index,
                      const Use& use) {
  if constexpr (std::is_same_v<Target, Ray>) {
    if (query.spacing_factor > 0.0)
      return use(OctreePlaces(view, query.max_level), OwnRadiusTarget(view, target, query, query_index));
  }
  return use(OctreeTree(view, query.max_level), make_target(target, query, query_index));
}

}  // namespace alidade
