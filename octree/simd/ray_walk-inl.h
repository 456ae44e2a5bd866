// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_WALK_INL_H
#undef ALIDADE_SIMD_RAY_WALK_INL_H
#else
#define ALIDADE_SIMD_RAY_WALK_INL_H
#endif

#include <hwy/cache_control.h>

#include "octree/simd/box_test-inl.h"
#include "octree/simd/leaf_test-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// What stays the same for all rays of a query.
template <class Points, bool any>
struct Traversed {
  const QuerySetup& setup;
  const LeafTest<Points, any>& leaf_test;
  int max_depth;       ///< nodes below are not visited
  bool skips_twins;    ///< of points at one position only the first is examined
  bool rejects_twins;  ///< or none, if the query rejects the position

  Traversed(const QuerySetup& query_setup, const LeafTest<Points, any>& test)
      : setup(query_setup),
        leaf_test(test),
        max_depth(setup.query.max_level),
        skips_twins(!setup.query.filter.of_point && setup.query.max_level == k_all_levels),
        rejects_twins(setup.query.filter.of_point && setup.query.filter.of_position) {}

  /// Whether points of the node's first position are in more than one of its slots.
  static bool has_twins(const Slots& slots, const SamePositions& same) {
    const unsigned filled = slots.leaf | slots.inner;
    return (filled & 1u) != 0 && (filled & same.twins) != 0;
  }

  /// Whether the query rejects that position. corner: of the node's frame, which has the lowest level.
  bool rejects_first_position(const ActiveRay& ray, const Node& node,
                              const std::array<std::uint32_t, 3>& corner) const {
    const Node* holder = &node;
    while (is_inner(holder->kind[0])) holder = setup.tree.nodes + holder->first_child;
    const Leaf leaf{holder->first_point, holder->kind[0], corner};
    return leaf_test.rejects_first(ray, leaf);
  }
};

/// A single ray as it meets boxes. t of the face at grid step q of a frame is q * step * 2^(level - 8) +
/// corner * step - origin_t, with the frame's corner in lattice steps from the setup's, and `reach` before
/// that for near faces, behind it for far ones. Points::slot_reach() is taken off later.
template <class Points>
struct RayOnGrid {
  float step[3], origin_t[3];
  float reach[3], reach_in_site[3];
  float way[3];                            ///< along the ray for a metre along the axis
  std::ptrdiff_t near_row[3], far_row[3];  ///< bytes from the node's start

  RayOnGrid(const QuerySetup& setup, const RayBoxes& boxes) {
    const auto widening = static_cast<float>(Points::own_radii ? setup.box_margin : setup.box_radius);
    const auto in_site = static_cast<float>(Points::own_radii ? setup.site_margin : setup.site_radius);
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = boxes.inverse[axis] < 0.0f;
      step[axis] = setup.tree.extent.scale[axis] * boxes.inverse[axis];
      origin_t[axis] = boxes.origin_t[axis];
      way[axis] = std::fabs(boxes.inverse[axis]);
      reach[axis] = widening * way[axis];
      reach_in_site[axis] = in_site * way[axis];
      near_row[axis] = k_node_width * (negative ? 3 + axis : axis);
      far_row[axis] = k_node_width * (negative ? axis : 3 + axis);
    }
  }
};

/// Bit per slot: t_near <= t.
HWY_INLINE unsigned begin_before(const float* t_near, float t) {
  const ChildLanes d;
  unsigned before = 0;
  for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d))
    before |= mask_bits(d, hn::Le(hn::Load(d, t_near + lane), hn::Set(d, t))) << lane;
  return before;
}

/// 2^(level - 8): lattice steps of a grid step.
HWY_INLINE float grid_step_of(int level) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(127 + level - k_min_frame_level) << 23);
}

/// Slots whose widened box the ray meets between local t = 0 and t_cut, empty slots included, and where it
/// enters each. points: of the tree whose node has this number. corner: of the node's frame, lattice steps.
/// reach: RayOnGrid's for that frame.
template <class Points>
HWY_INLINE unsigned meet_boxes(const RayOnGrid<Points>& ray, float t_cut, const Points& points,
                               const Node& node, std::uint32_t number, const float* corner, int level,
                               const float* reach, float* t_near) {
  const ChildLanes d;
  const float grid_step = grid_step_of(level);
  float step[3], near[3], far[3];
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = ray.step[axis] * grid_step;
    const float base = corner[axis] * ray.step[axis] - ray.origin_t[axis];
    // `high` is inclusive: its face is one grid step further. That is the nearer one to a ray that goes down.
    near[axis] = base - reach[axis] + std::min(step[axis], 0.0f);
    far[axis] = base + reach[axis] + std::max(step[axis], 0.0f);
  }
  const auto* rows = &node.low[0][0];
  const auto on_axis = [&](std::ptrdiff_t row, int axis, float base) {
    return hn::MulAdd(load_as_float(d, rows + row), hn::Set(d, step[axis]), hn::Set(d, base));
  };
  unsigned meets = 0;
  for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
    auto enter = hn::Zero(d), leave = hn::Set(d, t_cut);
    for (int axis = 0; axis < 3; ++axis) {
      auto first = on_axis(ray.near_row[axis] + lane, axis, near[axis]),
           last = on_axis(ray.far_row[axis] + lane, axis, far[axis]);
      if constexpr (Points::own_radii) {
        const auto wider = points.slot_reach(d, number, axis, lane), way = hn::Set(d, ray.way[axis]);
        first = hn::NegMulAdd(wider, way, first);
        last = hn::MulAdd(wider, way, last);
      }
      enter = hn::Max(enter, first);
      leave = hn::Min(leave, last);
    }
    hn::Store(hn::Abs(enter), d, t_near + lane);
    meets |= mask_bits(d, hn::Le(enter, leave)) << lane;
  }
  return meets;
}

/// One ray on its way through the tree, nearest nodes first, in steps: test a node's boxes, test the leaves
/// among them, go to the next node.
template <class Points, bool any>
class RayWalk {
 public:
  RayWalk(const Traversed<Points, any>& traversed, const ActiveRay& ray, const Frame& from)
      : ray_(ray),
        on_grid_(traversed.setup, ray.boxes),
        reference_(traversed.setup.reference),
        frame_{{traversed.setup.steps_to(from.corner[0], 0), traversed.setup.steps_to(from.corner[1], 1),
                traversed.setup.steps_to(from.corner[2], 2)},
               from.node,
               static_cast<std::uint16_t>(from.level),
               static_cast<std::uint16_t>(from.depth)} {}

  /// Whether the ray meets leaves of the node.
  HWY_INLINE bool meet_children(const Traversed<Points, any>& traversed) {
    const TreeView& tree = traversed.setup.tree;
    const Node& node = tree.nodes[frame_.node];
    const Slots slots(node);
    unsigned met =
        meet_boxes(on_grid_, ray_.boxes.t_cut, traversed.leaf_test.points(), node, frame_.node, frame_.corner,
                   frame_.level, in_site(traversed.setup) ? on_grid_.reach_in_site : on_grid_.reach, t_near_);
    single_ = 0;
    if (frame_.level == k_min_frame_level && (traversed.skips_twins || traversed.rejects_twins)) {
      const SamePositions same(node);
      if (traversed.skips_twins) {
        met &= ~same.twins;
        single_ = same.single;
      } else if ((met & same.twins) != 0 && traversed.has_twins(slots, same) &&
                 traversed.rejects_first_position(ray_, node, corner())) {
        met &= ~(same.twins | 1u);
      }
    }
    leaves_ = met & slots.leaf;
    inner_ = slots.inner;
    children_ = frame_.depth < traversed.max_depth ? met & slots.inner : 0u;
    return leaves_ != 0;
  }

  /// Fetches the points of the leaves that the ray meets.
  HWY_INLINE void prefetch_leaves(const Traversed<Points, any>& traversed) const {
    const Node& node = traversed.setup.tree.nodes[frame_.node];
    const Slots slots(node);
    for (unsigned leaves = leaves_; leaves != 0; leaves &= leaves - 1) {
      const int slot = std::countr_zero(leaves);
      traversed.leaf_test.fetch(slots.first_point(node, slot), node.kind[slot]);
    }
  }

  HWY_INLINE void prefetch_node(const Traversed<Points, any>& traversed) const {
    hwy::Prefetch(traversed.setup.tree.nodes + frame_.node);
  }

  /// Requires: meet_children() was true.
  HWY_INLINE void test_leaves(const Traversed<Points, any>& traversed) {
    const Node& node = traversed.setup.tree.nodes[frame_.node];
    const Slots slots(node);
    const float cut_before = ray_.boxes.t_cut;
    const std::array<std::uint32_t, 3> corner = this->corner();
    const auto leaf_frame = traversed.leaf_test.leaf_frame(corner, frame_.level);
    do {
      const int slot = std::countr_zero(leaves_ | 1u << (k_node_width - 1));
      leaves_ &= leaves_ - 1;
      if (t_near_[slot] > ray_.boxes.t_cut) continue;
      const std::uint32_t count = node.kind[slot];
      const Leaf leaf{slots.first_point(node, slot), count, corner};
      traversed.leaf_test.visit(ray_, leaf, (single_ >> slot & 1u) != 0 ? 1u : count, leaf_frame,
                                t_near_[slot]);
      if (any && ray_.state.found()) return;
    } while (leaves_ != 0);
    if (ray_.boxes.t_cut < cut_before) children_ &= begin_before(t_near_, ray_.boxes.t_cut);
  }

  /// To the next node; false at the end of the walk.
  HWY_INLINE bool next_node(const Traversed<Points, any>& traversed) {
    if (any && ray_.state.found()) return false;
    const Node* nodes = traversed.setup.tree.nodes;
    if (children_ != 0) {
      const Node& node = nodes[frame_.node];
      int slot = std::countr_zero(children_);
      children_ &= children_ - 1;
      if (children_ != 0) slot = keep_waiting(slot);
      frame_ = child(frame_, node, slot, inner_);
      return true;
    }
    // Of floats that are not below 0, and those that are, too.
    const auto cut = std::bit_cast<std::int32_t>(ray_.boxes.t_cut);
    Waiting chosen;
    do {
      if (waiting_count_ == 0) return false;
      chosen = waiting_[--waiting_count_];
    } while (static_cast<std::int32_t>(chosen >> 32) > cut);
    const FloatFrame& parent = parents_[chosen >> 8 & 0xff];
    const Node& node = nodes[parent.node];
    const int slot = static_cast<int>(chosen & 0xff);
    frame_ = child(parent, node, slot, inner_slots(node));
    return true;
  }

 private:
  /// A Frame with its corner as floats, which hold it exactly: it is a multiple of 256 within 2^32.
  struct FloatFrame {
    float corner[3];  ///< lattice steps from the setup's
    std::uint32_t node;
    std::uint16_t level;
    std::uint16_t depth;
  };

  /// From the root's corner.
  std::uint32_t lattice_steps(int axis) const {
    return reference_[axis] + static_cast<std::uint32_t>(static_cast<std::int64_t>(frame_.corner[axis]));
  }
  std::array<std::uint32_t, 3> corner() const {
    return {lattice_steps(0), lattice_steps(1), lattice_steps(2)};
  }

  /// QuerySetup::in_site() of the node.
  bool in_site(const QuerySetup& setup) const {
    if (!setup.has_site) return true;
    const auto width = static_cast<float>(power_of_two(setup.tree.extent.site_level));
    const auto within = [&](int axis) { return frame_.corner[axis] >= 0.0f && frame_.corner[axis] < width; };
    return frame_.level <= setup.tree.extent.site_level && within(0) && within(1) && within(2);
  }

  /// inner: of the parent's slots.
  HWY_INLINE static FloatFrame child(const FloatFrame& parent, const Node& node, int slot, unsigned inner) {
    const int drop = node.kind[slot] - k_inner_kind;
    const float grid_step = grid_step_of(parent.level);
    FloatFrame below;
    for (int axis = 0; axis < 3; ++axis)
      below.corner[axis] =
          parent.corner[axis] + static_cast<float>(node.low[axis][slot] & (-256 >> drop)) * grid_step;
    below.node = node.first_child + static_cast<unsigned>(std::popcount(inner & ((1u << slot) - 1u)));
    below.level = static_cast<std::uint16_t>(parent.level - drop);
    below.depth = static_cast<std::uint16_t>(parent.depth + 1);
    return below;
  }

  /// A child still to be visited: from high to low 32 bits its t, 24 bits depth of its parent, 8 bits slot.
  using Waiting = std::uint64_t;

  /// All children but the nearest wait, the farthest first, so that the nearer ones are visited earlier.
  HWY_INLINE int keep_waiting(int slot) {
    parents_[frame_.depth] = frame_;
    const int bottom = waiting_count_;
    do {
      int other = std::countr_zero(children_);
      children_ &= children_ - 1;
      if (t_near_[other] < t_near_[slot]) std::swap(slot, other);
      const Waiting farther = Waiting{std::bit_cast<std::uint32_t>(t_near_[other])} << 32 |
                              Waiting{frame_.depth} << 8 | static_cast<unsigned>(other);
      int at = waiting_count_++;
      for (; at > bottom && waiting_[at - 1] < farther; --at) waiting_[at] = waiting_[at - 1];
      waiting_[at] = farther;
    } while (children_ != 0);
    return slot;
  }

  ActiveRay ray_;
  RayOnGrid<Points> on_grid_;
  std::array<std::uint32_t, 3> reference_;
  FloatFrame frame_;
  unsigned leaves_, children_, inner_, single_;
  int waiting_count_ = 0;
  alignas(64) float t_near_[k_node_width];
  FloatFrame parents_[k_max_tree_depth + 1];  ///< of the children that wait, by depth
  Waiting waiting_[k_max_tree_depth * (k_node_width - 1) + 1];
};

/// One ray from one node on.
template <class Points, bool any>
void trace(const Traversed<Points, any>& traversed, const ActiveRay& ray, const Frame& from) {
  RayWalk<Points, any> walk(traversed, ray, from);
  do {
    if (walk.meet_children(traversed)) walk.test_leaves(traversed);
  } while (walk.next_node(traversed));
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
