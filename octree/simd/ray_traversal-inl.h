// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_TRAVERSAL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_TRAVERSAL_INL_H
#undef ALIDADE_SIMD_RAY_TRAVERSAL_INL_H
#else
#define ALIDADE_SIMD_RAY_TRAVERSAL_INL_H
#endif

#include <hwy/cache_control.h>

#include "octree/simd/box_test-inl.h"
#include "octree/simd/leaf_test-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// What stays the same for all rays of a query.
template <Measure measure, bool any, Radii radii>
struct Traversed {
  const QuerySetup& setup;
  const LeafTest<measure, any, radii>& leaf_test;
  int max_depth;     ///< nodes below are not visited
  bool skips_twins;  ///< of points at one place only the first is looked at

  Traversed(const QuerySetup& query_setup, const LeafTest<measure, any, radii>& test)
      : setup(query_setup),
        leaf_test(test),
        max_depth(setup.query.max_level),
        skips_twins(!setup.query.filter && setup.query.max_level == k_all_levels) {}
};

/// One ray on its way through the tree, nearest nodes first, in steps: look at a node's boxes, test the
/// leaves among them, go on to the next node.
template <Measure measure, bool any, Radii radii>
class RayWalk {
 public:
  RayWalk(const Traversed<measure, any, radii>& traversed, const RayUnderWay& ray, const Visit& from)
      : ray_(ray),
        on_grid_(traversed.setup, ray.boxes),
        at_{{static_cast<float>(from.corner[0]), static_cast<float>(from.corner[1]),
             static_cast<float>(from.corner[2])},
            from.node,
            from.level,
            from.depth} {}

  /// Whether the ray meets leaves of the node.
  HWY_INLINE bool look(const Traversed<measure, any, radii>& traversed) {
    const TreeView& tree = traversed.setup.tree;
    const Node& node = tree.nodes[at_.node];
    const Slots slots(node);
    unsigned met = meet_boxes(ray_.boxes, on_grid_, node, at_.corner, at_.level,
                              traversed.leaf_test.own_radii(), slot_spacings(tree, at_.node), t_near_);
    single_ = 0;
    if (at_.level == k_min_frame_level && traversed.skips_twins) {
      const Places places(node);
      met &= ~places.twins;
      single_ = places.single;
    }
    leaves_ = met & slots.leaf;
    inner_ = slots.inner;
    children_ = at_.depth < traversed.max_depth ? met & slots.inner : 0u;
    return leaves_ != 0;
  }

  /// Fetches the points of the leaves that the ray meets.
  HWY_INLINE void prefetch_leaves(const Traversed<measure, any, radii>& traversed) const {
    const Node& node = traversed.setup.tree.nodes[at_.node];
    const Slots slots(node);
    for (unsigned leaves = leaves_; leaves != 0; leaves &= leaves - 1) {
      const int slot = std::countr_zero(leaves);
      const std::uint16_t* coordinates =
          traversed.setup.tree.coordinates + std::size_t{3} * slots.first_point(node, slot);
      const int values = 3 * node.kind[slot];
      for (int value = 0; value < values; value += 32) hwy::Prefetch(coordinates + value);
    }
  }

  HWY_INLINE void prefetch_node(const Traversed<measure, any, radii>& traversed) const {
    hwy::Prefetch(traversed.setup.tree.nodes + at_.node);
  }

  /// Requires: look() was true.
  HWY_INLINE void test_leaves(const Traversed<measure, any, radii>& traversed) {
    const Node& node = traversed.setup.tree.nodes[at_.node];
    const Slots slots(node);
    const float cut_before = ray_.boxes.t_cut;
    const std::uint32_t corner[3] = {lattice_steps(at_.corner[0]), lattice_steps(at_.corner[1]),
                                     lattice_steps(at_.corner[2])};
    const auto place = traversed.leaf_test.place(corner, at_.level);
    do {
      const int slot = std::countr_zero(leaves_ | 0x80u);
      leaves_ &= leaves_ - 1;
      if (t_near_[slot] > ray_.boxes.t_cut) continue;
      const std::uint32_t count = node.kind[slot];
      const Leaf leaf{slots.first_point(node, slot), count, {corner[0], corner[1], corner[2]}};
      traversed.leaf_test.visit(ray_, leaf, (single_ >> slot & 1u) != 0 ? 1u : count, place, t_near_[slot]);
      if (any && ray_.state.found()) return;
    } while (leaves_ != 0);
    if (ray_.boxes.t_cut < cut_before) children_ &= begin_before(t_near_, ray_.boxes.t_cut);
  }

  /// To the next node; false at the end of the way.
  HWY_INLINE bool go_on(const Traversed<measure, any, radii>& traversed) {
    if (any && ray_.state.found()) return false;
    const Node* nodes = traversed.setup.tree.nodes;
    if (children_ != 0) {
      const Node& node = nodes[at_.node];
      int slot = std::countr_zero(children_);
      children_ &= children_ - 1;
      if (children_ != 0) slot = keep_waiting(slot);
      at_ = child(at_, node, slot, inner_);
      return true;
    }
    // Of floats that are not below 0, and those that are, too.
    const auto cut = std::bit_cast<std::int32_t>(ray_.boxes.t_cut);
    Waiting chosen;
    do {
      if (waiting_count_ == 0) return false;
      chosen = waiting_[--waiting_count_];
    } while (static_cast<std::int32_t>(chosen >> 32) > cut);
    const Place& parent = way_[chosen >> 8 & 0xff];
    const Node& node = nodes[parent.node];
    const int slot = static_cast<int>(chosen & 7);
    at_ = child(parent, node, slot, Slots::inner_of(node));
    return true;
  }

 private:
  /// A node, with the corner of its frame as floats, which hold it exactly: it is a multiple of 256 below
  /// 2^32.
  struct Place {
    float corner[3];  ///< lattice steps from the root's
    std::uint32_t node;
    std::uint16_t level;
    std::uint16_t depth;
  };

  static std::uint32_t lattice_steps(float corner) { return static_cast<std::uint32_t>(corner); }

  /// inner: of the parent's slots.
  HWY_INLINE static Place child(const Place& parent, const Node& node, int slot, unsigned inner) {
    const int drop = node.kind[slot] - k_inner_kind;
    const auto grid_step =
        std::bit_cast<float>(static_cast<std::uint32_t>(127 + parent.level - k_min_frame_level) << 23);
    Place place;
    for (int axis = 0; axis < 3; ++axis)
      place.corner[axis] =
          parent.corner[axis] + static_cast<float>(node.low[axis][slot] & (-256 >> drop)) * grid_step;
    place.node = node.first_child + static_cast<unsigned>(std::popcount(inner & ((1u << slot) - 1u)));
    place.level = static_cast<std::uint16_t>(parent.level - drop);
    place.depth = static_cast<std::uint16_t>(parent.depth + 1);
    return place;
  }

  /// A child still to be visited: from high to low 32 bits its t, 24 bits depth of its parent, 8 bits slot.
  using Waiting = std::uint64_t;

  /// All children but the nearest wait, the farthest first, so that the nearer ones are visited earlier.
  HWY_INLINE int keep_waiting(int slot) {
    way_[at_.depth] = at_;
    const int bottom = waiting_count_;
    do {
      int other = std::countr_zero(children_);
      children_ &= children_ - 1;
      if (t_near_[other] < t_near_[slot]) std::swap(slot, other);
      const Waiting farther = Waiting{std::bit_cast<std::uint32_t>(t_near_[other])} << 32 |
                              Waiting{at_.depth} << 8 | static_cast<unsigned>(other);
      int at = waiting_count_++;
      for (; at > bottom && waiting_[at - 1] < farther; --at) waiting_[at] = waiting_[at - 1];
      waiting_[at] = farther;
    } while (children_ != 0);
    return slot;
  }

  RayUnderWay ray_;
  RayOnGrid<radii> on_grid_;
  Place at_;
  unsigned leaves_, children_, inner_, single_;
  int waiting_count_ = 0;
  alignas(32) float t_near_[k_node_width];
  Place way_[k_max_tree_depth + 1];  ///< the nodes whose other children wait, by depth
  Waiting waiting_[k_max_tree_depth * (k_node_width - 1) + 1];
};

/// One ray from one node on.
template <Measure measure, bool any, Radii radii>
void trace(const Traversed<measure, any, radii>& traversed, const RayUnderWay& ray, const Visit& from) {
  RayWalk<measure, any, radii> walk(traversed, ray, from);
  do {
    if (walk.look(traversed)) walk.test_leaves(traversed);
  } while (walk.go_on(traversed));
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
