// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_TRAVERSAL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_TRAVERSAL_INL_H
#undef ALIDADE_SIMD_RAY_TRAVERSAL_INL_H
#else
#define ALIDADE_SIMD_RAY_TRAVERSAL_INL_H
#endif

#include <array>
#include <cstring>

#include "octree/simd/leaf_test-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// A node still to be visited, with the frame that its parent told.
struct Visit {
  float t_near;
  std::uint32_t node;
  std::uint32_t corner[3];
  std::uint16_t level;
  std::uint16_t depth;
};

inline Visit root_visit(const TreeView& tree) {
  return {
      -std::numeric_limits<float>::infinity(), 0, {0, 0, 0}, static_cast<std::uint16_t>(tree.root_level), 0};
}

/// What the slots of a node hold, as bits and bytes per slot.
struct Slots {
  unsigned inner;               ///< bit per slot
  unsigned leaf;                ///< bit per slot
  std::uint64_t points_before;  ///< byte per slot: points of the leaf slots before it

  explicit Slots(const Node& node) {
    std::uint64_t kinds;
    std::memcpy(&kinds, node.kind, 8);
    constexpr std::uint64_t k_high_bits = 0x8080808080808080u;
    inner = gather_high_bits(kinds & k_high_bits);
    const std::uint64_t leaf_counts = kinds & ~((kinds >> 7 & 0x0101010101010101u) * 0xff);
    leaf = gather_high_bits((leaf_counts + 0x7f7f7f7f7f7f7f7fu) & k_high_bits);
    // Each byte of the product holds the sum of all lower counts (at most 7 * 32).
    points_before = leaf_counts * 0x0101010101010100u;
  }

  std::uint32_t first_point(const Node& node, int slot) const {
    return node.first_point + static_cast<std::uint32_t>(points_before >> (8 * slot) & 0xff);
  }
  std::uint32_t child(const Node& node, int slot) const {
    return node.first_child + static_cast<unsigned>(std::popcount(inner & ((1u << slot) - 1u)));
  }
};

/// Slots of a node at the lowest level whose points all stand at one place. Boxes are exact there, and ids
/// rise from point to point and from slot to slot of one place; so only the first point of the first such
/// slot can be the answer to `closest` without a filter (but for layered trees, whose samples break that
/// order). This is what keeps a ray through a million equal points from testing each.
struct Places {
  unsigned single = 0;  ///< bit per slot: one place
  unsigned twins = 0;   ///< of these, those at the place of slot 0, without slot 0

  explicit Places(const Node& node) {
    std::uint64_t spread = 0, difference = 0;
    for (int axis = 0; axis < 3; ++axis) {
      std::uint64_t low, high;
      std::memcpy(&low, node.low[axis], 8);
      std::memcpy(&high, node.high[axis], 8);
      spread |= low ^ high;
      difference |= low ^ (node.low[axis][0] * 0x0101010101010101u);
    }
    single = zero_bytes(spread);
    twins = (single & 1u) != 0 ? zero_bytes(spread | difference) & ~1u : 0u;
  }

 private:
  static unsigned zero_bytes(std::uint64_t word) {
    constexpr std::uint64_t k_low_bits = 0x7f7f7f7f7f7f7f7fu;
    return gather_high_bits(~(((word & k_low_bits) + k_low_bits) | word) & ~k_low_bits);
  }
};

/// One ray through the tree, nearest nodes first.
template <Measure measure, bool any>
class RayTraversal {
 public:
  RayTraversal(const QuerySetup& setup, const LeafTest<measure, any>& leaf_test)
      : setup_(setup),
        leaf_test_(leaf_test),
        max_depth_(setup.query.max_level),
        skips_twins_(!setup.query.filter && setup.tree.organisation != Organisation::layered) {}

  int max_depth() const { return max_depth_; }
  /// Whether of points at one place only the first is looked at.
  bool skips_twins() const { return skips_twins_; }

  /// From one node on. Requires: !state.misses && !state.exhaustive.
  void run(RayState& state, const Visit& from) const {
    const double reach = setup_.box_radius + state.double_error;
    RayOnGrid ray;
    for (int axis = 0; axis < 3; ++axis) {
      ray.steps[axis] = setup_.float_scale[axis] * state.inverse[axis];
      ray.reach[axis] = static_cast<float>(reach) * std::fabs(state.inverse[axis]);
      ray.near_step[axis] = (state.octant >> axis & 1) != 0 ? ray.steps[axis] : 0.0f;
      ray.far_step[axis] = (state.octant >> axis & 1) != 0 ? 0.0f : ray.steps[axis];
      const int low_row = axis, high_row = 3 + axis;
      ray.near_row[axis] = 8 * ((state.octant >> axis & 1) != 0 ? high_row : low_row);
      ray.far_row[axis] = 8 * ((state.octant >> axis & 1) != 0 ? low_row : high_row);
    }
    Visit stack[k_stack_size];
    int stack_count = 1;
    stack[0] = from;
    while (stack_count > 0) {
      const Visit visit = stack[--stack_count];
      if (visit.t_near > state.t_cut) continue;
      visit_node(state, ray, visit, stack, stack_count);
      if (any && state.found) return;
    }
  }

 private:
  static constexpr int k_stack_size = k_max_tree_depth * (k_node_width - 1) + 1;

  /// What of a ray meets boxes; t of grid step q of a frame is base + q * steps * 2^(level - 8).
  struct RayOnGrid {
    float steps[4] = {};  ///< t per lattice step
    float reach[4] = {};  ///< widening of a slab, in t
    /// `high` is inclusive: its far face stands one grid step further. That is the nearer one to a ray that
    /// goes down.
    float near_step[4] = {}, far_step[4] = {};
    int near_row[3], far_row[3];  ///< bytes from the node's start
  };

  void visit_node(RayState& state, const RayOnGrid& ray, const Visit& visit, Visit* stack,
                  int& stack_count) const {
    const Node& node = setup_.tree.nodes[visit.node];
    alignas(32) float t_near[k_node_width];
    unsigned met = meet_boxes(state, ray, node, visit, t_near);
    const Slots slots(node);
    unsigned single = 0;
    if (visit.level == k_min_frame_level && skips_twins_) {
      const Places places(node);
      met &= ~places.twins;
      single = places.single;
    }
    for (unsigned leaves = met & slots.leaf; leaves != 0; leaves &= leaves - 1) {
      const int slot = std::countr_zero(leaves);
      if (t_near[slot] > state.t_cut) continue;
      const std::uint32_t count = node.kind[slot];
      Leaf leaf{slots.first_point(node, slot), count, {visit.corner[0], visit.corner[1], visit.corner[2]}};
      leaf_test_.visit(state, leaf, (single >> slot & 1u) != 0 ? 1u : count, visit.level);
      if (any && state.found) return;
    }
    if (visit.depth >= max_depth_) return;

    // Farthest first on the stack, so that the nearest is visited next.
    const int bottom = stack_count;
    for (unsigned children = met & slots.inner; children != 0; children &= children - 1) {
      const int slot = std::countr_zero(children);
      if (t_near[slot] > state.t_cut) continue;
      const int drop = node.kind[slot] - k_inner_kind;
      Visit child;
      child.t_near = t_near[slot];
      child.node = slots.child(node, slot);
      for (int axis = 0; axis < 3; ++axis)
        child.corner[axis] = visit.corner[axis] + child_corner(node.low[axis][slot], visit.level, drop);
      child.level = static_cast<std::uint16_t>(visit.level - drop);
      child.depth = static_cast<std::uint16_t>(visit.depth + 1);
      int at = stack_count++;
      for (; at > bottom && stack[at - 1].t_near < child.t_near; --at) stack[at] = stack[at - 1];
      stack[at] = child;
    }
  }

  /// Slots whose widened box the ray meets between t_low and t_cut, empty ones included, and where it enters
  /// each.
  HWY_INLINE unsigned meet_boxes(const RayState& state, const RayOnGrid& ray, const Node& node,
                                 const Visit& visit, float* t_near) const {
    const auto grid_step = static_cast<float>(power_of_two(visit.level - k_min_frame_level));
    float step[4], near_base[4], far_base[4];
    for (int axis = 0; axis < 3; ++axis) {
      // A multiple of 256 below 2^32: its upper 24 bits make an exact float.
      const float corner = static_cast<float>(static_cast<std::int32_t>(visit.corner[axis] >> 8)) * 256.0f;
      const float base = corner * ray.steps[axis] - state.origin_t[axis];
      step[axis] = ray.steps[axis] * grid_step;
      near_base[axis] = base + (ray.near_step[axis] * grid_step - ray.reach[axis]);
      far_base[axis] = base + (ray.far_step[axis] * grid_step + ray.reach[axis]);
    }
    const ChildLanes d;
    const auto* rows = &node.low[0][0];
    const auto low = hn::Set(d, state.t_low), cut = hn::Set(d, state.t_cut);
    unsigned met = 0;
    for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
      const auto near_face = [&](int axis) {
        return hn::MulAdd(load_as_float(d, rows + ray.near_row[axis] + lane), hn::Set(d, step[axis]),
                          hn::Set(d, near_base[axis]));
      };
      const auto far_face = [&](int axis) {
        return hn::MulAdd(load_as_float(d, rows + ray.far_row[axis] + lane), hn::Set(d, step[axis]),
                          hn::Set(d, far_base[axis]));
      };
      const auto enter = hn::Max(hn::Max(near_face(0), near_face(1)), near_face(2));
      const auto leave = hn::Min(hn::Min(far_face(0), far_face(1)), far_face(2));
      hn::StoreU(enter, d, t_near + lane);
      const auto meets = hn::And(hn::And(hn::Le(enter, leave), hn::Ge(leave, low)), hn::Le(enter, cut));
      met |= mask_bits(d, meets) << lane;
    }
    return met;
  }

  const QuerySetup& setup_;
  const LeafTest<measure, any>& leaf_test_;
  const int max_depth_;
  const bool skips_twins_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
