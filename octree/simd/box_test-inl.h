// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_BOX_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_BOX_TEST_INL_H
#undef ALIDADE_SIMD_BOX_TEST_INL_H
#else
#define ALIDADE_SIMD_BOX_TEST_INL_H
#endif

#include <algorithm>
#include <bit>

#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"
#include "octree/tree_walk.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// What the slots of a node hold.
struct Slots {
  unsigned inner;    ///< bit per slot
  unsigned leaf;     ///< bit per slot
  SlotBytes counts;  ///< points of the leaf slots, 0 of the others

  explicit Slots(const Node& node) : inner(inner_slots(node)), leaf(0), counts(leaf_counts(node)) {
    leaf = counts.nonzero();
  }

  std::uint32_t first_point(const Node& node, int slot) const {
    return node.first_point + counts.sum_before(slot);
  }
  std::uint32_t child(const Node& node, int slot) const {
    return node.first_child + static_cast<unsigned>(std::popcount(inner & ((1u << slot) - 1u)));
  }
  HWY_INLINE Leaf leaf_in(const Node& node, const Frame& frame, int slot) const {
    return {first_point(node, slot), node.kind[slot], frame.corner, frame.depth};
  }
  HWY_INLINE Frame child_in(const Node& node, const Frame& frame, int slot) const {
    const int drop = node.kind[slot] - k_inner_kind;
    Frame below{child(node, slot), frame.corner, frame.level - drop, frame.depth + 1};
    for (int axis = 0; axis < 3; ++axis)
      below.corner[axis] += child_corner(node.low[axis][slot], frame.level, drop);
    return below;
  }
};

/// Slots of a node at the lowest level whose points all have equal positions. Boxes are exact there, and ids
/// rise from point to point and from slot to slot of one position (node.h); so only the first point of the
/// first such slot can be the answer to `closest` without a filter and with all levels. This is what keeps a
/// ray through a million equal points from testing each.
struct SamePositions {
  unsigned single = 0;  ///< bit per slot: one position
  unsigned twins = 0;   ///< of these, those at the position of slot 0, without slot 0

  explicit SamePositions(const Node& node) {
    SlotBytes spread = SlotBytes::fill(0), difference = spread;
    for (int axis = 0; axis < 3; ++axis) {
      const SlotBytes low = SlotBytes::load(node.low[axis]), high = SlotBytes::load(node.high[axis]);
      spread = spread | (low ^ high);
      difference = difference | (low ^ SlotBytes::fill(node.low[axis][0]));
    }
    constexpr unsigned k_all_slots = (1u << k_node_width) - 1u;
    single = ~spread.nonzero() & k_all_slots;
    if ((single & 1u) != 0) twins = ~(spread | difference).nonzero() & k_all_slots & ~1u;
  }
};

/// A single ray as it meets boxes. t of the face at grid step q of a frame is q * step * 2^(level - 8) +
/// corner * step - origin_t, with the frame's corner in lattice steps from the root's, and `reach` before that for
/// near faces, behind it for far ones. Radii of the points' own are taken off later.
template <Radii radii>
struct RayOnGrid {
  float step[3], reach[3];
  float way[3];                 ///< along the ray for a metre along the axis
  int near_row[3], far_row[3];  ///< bytes from the node's start

  RayOnGrid(const QuerySetup& setup, const RayBoxes& boxes) {
    const auto widening = static_cast<float>(radii == Radii::own ? setup.box_margin : setup.box_radius);
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = boxes.inverse[axis] < 0.0f;
      step[axis] = setup.float_scale[axis] * boxes.inverse[axis];
      way[axis] = std::fabs(boxes.inverse[axis]);
      reach[axis] = widening * way[axis];
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

/// Slots whose widened box the ray meets between t_low and t_cut, empty ones included, and where it enters
/// each; rounding below 0, where it enters the root's box, is left out. corner: of the node's frame, lattice
/// steps. spacings: of the node's slots; only for Radii::own.
template <Radii radii>
HWY_INLINE unsigned meet_boxes(const RayBoxes& boxes, const RayOnGrid<radii>& ray, const Node& node,
                               const float* corner, int level, const OwnRadii& own_radii,
                               const std::uint16_t* spacings, float* t_near) {
  const ChildLanes d;
  const auto* rows = &node.low[0][0];
  const auto grid_step =
      std::bit_cast<float>(static_cast<std::uint32_t>(127 + level - k_min_frame_level) << 23);
  float step[3], near[3], far[3];
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = ray.step[axis] * grid_step;
    const float base = corner[axis] * ray.step[axis] - boxes.origin_t[axis];
    // `high` is inclusive: its face stands one grid step further. That is the nearer one to a ray that goes down.
    near[axis] = base - ray.reach[axis] + std::min(step[axis], 0.0f);
    far[axis] = base + ray.reach[axis] + std::max(step[axis], 0.0f);
  }
  unsigned meets = 0;
  for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
    auto enter = hn::Set(d, boxes.t_low), leave = hn::Set(d, boxes.t_cut), radius = hn::Zero(d);
    if constexpr (radii == Radii::own) radius = own_radii.above(d, spacings + lane);
    for (int axis = 0; axis < 3; ++axis) {
      const auto on_axis = [&](int row, float base) {
        return hn::MulAdd(load_as_float(d, rows + row + lane), hn::Set(d, step[axis]), hn::Set(d, base));
      };
      auto first = on_axis(ray.near_row[axis], near[axis]), last = on_axis(ray.far_row[axis], far[axis]);
      if constexpr (radii == Radii::own) {
        first = hn::NegMulAdd(radius, hn::Set(d, ray.way[axis]), first);
        last = hn::MulAdd(radius, hn::Set(d, ray.way[axis]), last);
      }
      enter = hn::Max(enter, first);
      leave = hn::Min(leave, last);
    }
    hn::Store(hn::Abs(hn::Max(enter, hn::Zero(d))), d, t_near + lane);
    meets |= mask_bits(d, hn::Le(enter, leave)) << lane;
  }
  return meets;
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
