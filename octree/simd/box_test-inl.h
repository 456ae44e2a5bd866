// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_BOX_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_BOX_TEST_INL_H
#undef ALIDADE_SIMD_BOX_TEST_INL_H
#else
#define ALIDADE_SIMD_BOX_TEST_INL_H
#endif

#include <bit>
#include <cstring>

#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// A node under visit, with the frame that its parent told.
struct Visit {
  std::uint32_t corner[4];  ///< lattice steps from the root's; the last is padding
  std::uint32_t node;
  std::uint16_t level;
  std::uint16_t depth;
};

inline Visit root_visit(const TreeView& tree) {
  return {{0, 0, 0, 0}, 0, static_cast<std::uint16_t>(tree.root_level), 0};
}

/// What the slots of a node hold, as bits and bytes per slot.
struct Slots {
  unsigned inner;               ///< bit per slot
  unsigned leaf;                ///< bit per slot
  std::uint64_t points_before;  ///< byte per slot: points of the leaf slots before it

  static constexpr std::uint64_t k_high_bits = 0x8080808080808080u;

  static unsigned inner_of(const Node& node) {
    std::uint64_t kinds;
    std::memcpy(&kinds, node.kind, 8);
    return gather_high_bits(kinds & k_high_bits);
  }

  explicit Slots(const Node& node) : inner(inner_of(node)) {
    std::uint64_t kinds;
    std::memcpy(&kinds, node.kind, 8);
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
/// rise from point to point and from slot to slot of one place (node.h); so only the first point of the first
/// such slot can be the answer to `closest` without a filter and with all levels. This is what keeps a ray
/// through a million equal points from testing each.
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

/// The visit of an inner child.
HWY_INLINE Visit child_visit(const Visit& visit, const Node& node, std::uint32_t child, int slot) {
  const int drop = node.kind[slot] - k_inner_kind;
  Visit inner;
  for (int axis = 0; axis < 3; ++axis)
    inner.corner[axis] = visit.corner[axis] + child_corner(node.low[axis][slot], visit.level, drop);
  inner.corner[3] = 0;
  inner.node = child;
  inner.level = static_cast<std::uint16_t>(visit.level - drop);
  inner.depth = static_cast<std::uint16_t>(visit.depth + 1);
  return inner;
}

/// Integers in the order of the floats.
inline std::uint32_t order_key(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return bits ^ (static_cast<std::uint32_t>(static_cast<std::int32_t>(bits) >> 31) | 0x80000000u);
}

/// What of a ray meets boxes; t of grid step q of a frame is base + q * steps * 2^(level - 8).
struct RayOnGrid {
  alignas(16) float steps[4] = {};         ///< t per lattice step
  alignas(16) float corner_steps[4] = {};  ///< t per 256 lattice steps
  alignas(16) float origin_t[4] = {};
  alignas(16) float reach[4] = {};  ///< widening of a slab, in t
  /// `high` is inclusive: its far face stands one grid step further. That is the nearer one to a ray that
  /// goes down.
  alignas(16) float near_step[4] = {}, far_step[4] = {};
  int near_row[3], far_row[3];  ///< bytes from the node's start

  RayOnGrid(const QuerySetup& setup, const RayBoxes& boxes) {
    const auto widening = static_cast<float>(setup.box_radius);
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = boxes.inverse[axis] < 0.0f;
      steps[axis] = setup.float_scale[axis] * boxes.inverse[axis];
      corner_steps[axis] = 256.0f * steps[axis];
      origin_t[axis] = boxes.origin_t[axis];
      reach[axis] = widening * std::fabs(boxes.inverse[axis]);
      near_step[axis] = negative ? steps[axis] : 0.0f;
      far_step[axis] = negative ? 0.0f : steps[axis];
      near_row[axis] = 8 * (negative ? 3 + axis : axis);
      far_row[axis] = 8 * (negative ? axis : 3 + axis);
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

/// Slots whose widened box the ray meets between t_low and t_cut, empty ones included; where it enters
/// each, and the order of these places.
HWY_INLINE unsigned meet_boxes(const RayBoxes& boxes, const RayOnGrid& ray, const Node& node,
                               const Visit& visit, float* t_near, std::uint32_t* keys) {
  const ChildLanes d;
  const hn::RebindToUnsigned<ChildLanes> bits;
  const hn::RebindToSigned<ChildLanes> ints;
  const auto* rows = &node.low[0][0];
  const auto low = hn::Set(d, boxes.t_low), cut = hn::Set(d, boxes.t_cut);
  const auto grid_step = hn::Set(d, static_cast<float>(power_of_two(visit.level - k_min_frame_level)));
  unsigned met = 0;
  for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
    // Every lane does the frame's share of the work, too: what one lane stored could not be read by all in
    // time.
    auto enter = low, leave = cut;
    for (int axis = 0; axis < 3; ++axis) {
      // A multiple of 256 below 2^32: its upper 24 bits make an exact float.
      const auto corner =
          hn::ConvertTo(d, hn::BitCast(ints, hn::ShiftRight<8>(hn::Set(bits, visit.corner[axis]))));
      const auto base =
          hn::MulSub(corner, hn::Set(d, ray.corner_steps[axis]), hn::Set(d, ray.origin_t[axis]));
      const auto step = hn::Mul(hn::Set(d, ray.steps[axis]), grid_step);
      const auto reach = hn::Set(d, ray.reach[axis]);
      const auto near_base = hn::Add(base, hn::MulSub(hn::Set(d, ray.near_step[axis]), grid_step, reach));
      const auto far_base = hn::Add(base, hn::MulAdd(hn::Set(d, ray.far_step[axis]), grid_step, reach));
      const auto near = hn::MulAdd(load_as_float(d, rows + ray.near_row[axis] + lane), step, near_base);
      const auto far = hn::MulAdd(load_as_float(d, rows + ray.far_row[axis] + lane), step, far_base);
      enter = axis == 0 ? near : hn::Max(enter, near);
      leave = axis == 0 ? far : hn::Min(leave, far);
    }
    hn::Store(enter, d, t_near + lane);
    const auto enter_bits = hn::BitCast(bits, enter);
    const auto sign =
        hn::BitCast(bits, hn::ShiftRight<31>(hn::BitCast(hn::RebindToSigned<ChildLanes>(), enter_bits)));
    hn::Store(hn::Xor(enter_bits, hn::Or(sign, hn::Set(bits, 0x80000000u))), bits, keys + lane);
    const auto meets = hn::And(hn::And(hn::Le(enter, leave), hn::Ge(leave, low)), hn::Le(enter, cut));
    met |= mask_bits(d, meets) << lane;
  }
  return met;
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
