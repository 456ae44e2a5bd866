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
#include "octree/tree_walk.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// What the slots of a node hold, as bits and bytes per slot.
struct Slots {
  unsigned inner;               ///< bit per slot
  unsigned leaf;                ///< bit per slot
  std::uint64_t points_before;  ///< byte per slot: points of the leaf slots before it

  static unsigned inner_of(const Node& node) { return gather_high_bits(inner_bits(kinds_of(node))); }

  explicit Slots(const Node& node) : inner(inner_of(node)) {
    const std::uint64_t counts = leaf_counts(kinds_of(node));
    leaf = gather_high_bits((counts + 0x7f * k_every_byte) & (k_every_byte << 7));
    // Each byte of the product holds the sum of all lower counts (at most 7 * 32).
    points_before = counts * (k_every_byte - 1);
  }

  std::uint32_t first_point(const Node& node, int slot) const {
    return node.first_point + static_cast<std::uint32_t>(points_before >> (8 * slot) & 0xff);
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
    std::uint64_t spread = 0, difference = 0;
    for (int axis = 0; axis < 3; ++axis) {
      std::uint64_t low, high;
      std::memcpy(&low, node.low[axis], 8);
      std::memcpy(&high, node.high[axis], 8);
      spread |= low ^ high;
      difference |= low ^ (node.low[axis][0] * k_every_byte);
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

/// Near faces in the lower, far faces in the upper half.
using FaceLanes = hn::CappedTag<float, 2 * k_node_width>;

/// A vector's worth, from `lane` on, of one value for all near faces and one for all far faces.
HWY_INLINE hn::Vec<FaceLanes> near_and_far(std::size_t lane, float near, float far) {
  const FaceLanes d;
#if HWY_TARGET == HWY_AVX3
  (void)lane;
  return hn::IfThenElse(hn::FirstN(d, k_node_width), hn::Set(d, near), hn::Set(d, far));
#else
  return hn::Set(d, lane < k_node_width ? near : far);
#endif
}

/// A single ray as it meets boxes. t of the faces at grid step q of a frame, those of far faces negated, is
/// q * step * 2^(level - 8) + extra * 2^(level - 8) + corner * step + offset, with the frame's corner in
/// lattice steps from the root's: so the greatest of three axes is where the ray enters, and minus where it
/// leaves. Radii of the points' own are taken off later.
template <Radii radii>
struct alignas(64) RayOnGrid {
  float step[3][2 * k_node_width];
  float offset[3][2 * k_node_width];
  /// `high` is inclusive: its far face stands one grid step further. That is the nearer one to a ray that
  /// goes down.
  float extra[3][2 * k_node_width];
  int near_row[3], far_row[3];  ///< bytes from the node's start
  float way[3];                 ///< along the ray for a metre along the axis

  RayOnGrid(const QuerySetup& setup, const RayBoxes& boxes) {
    const FaceLanes d;
    const auto widening = static_cast<float>(radii == Radii::own ? setup.box_margin : setup.box_radius);
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = boxes.inverse[axis] < 0.0f;
      const float steps = setup.float_scale[axis] * boxes.inverse[axis];
      way[axis] = std::fabs(boxes.inverse[axis]);
      const float reach = widening * way[axis], origin_t = boxes.origin_t[axis];
      for (std::size_t lane = 0; lane < 2 * k_node_width; lane += hn::Lanes(d)) {
        hn::Store(near_and_far(lane, steps, -steps), d, step[axis] + lane);
        hn::Store(near_and_far(lane, -origin_t - reach, origin_t - reach), d, offset[axis] + lane);
        hn::Store(near_and_far(lane, negative ? steps : 0.0f, negative ? 0.0f : -steps), d,
                  extra[axis] + lane);
      }
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

/// Bytes of two rows, from `lane` of both on, as floats.
HWY_INLINE hn::Vec<FaceLanes> rows_as_floats(const std::uint8_t* near, const std::uint8_t* far,
                                             std::size_t lane) {
  const FaceLanes d;
#if HWY_TARGET == HWY_AVX3
  (void)lane;
  const hn::Rebind<std::uint8_t, FaceLanes> bytes;
  const hn::Half<decltype(bytes)> row;
  const hn::RebindToSigned<FaceLanes> ints;
  return hn::ConvertTo(d, hn::PromoteTo(ints, hn::Combine(bytes, hn::LoadU(row, far), hn::LoadU(row, near))));
#else
  return load_as_float(d, lane < k_node_width ? near + lane : far + (lane - k_node_width));
#endif
}

/// Radii of a node's slots for near and far faces.
HWY_INLINE hn::Vec<FaceLanes> slot_radii(const OwnRadii& own_radii, const std::uint16_t* spacings,
                                         std::size_t lane) {
  const FaceLanes d;
#if HWY_TARGET == HWY_AVX3
  (void)lane;
  const hn::Half<FaceLanes> half;
  const auto radii = own_radii.above(half, spacings);
  return hn::Combine(d, radii, radii);
#else
  return own_radii.above(d, spacings + lane % k_node_width);
#endif
}

/// Slots whose widened box the ray meets between t_low and t_cut, empty ones included, and where it enters
/// each; rounding below 0, where it enters the root's box, is left out. corner: of the node's frame, lattice
/// steps. spacings: of the node's slots; only for Radii::own.
template <Radii radii>
HWY_INLINE unsigned meet_boxes(const RayBoxes& boxes, const RayOnGrid<radii>& ray, const Node& node,
                               const float* corner, int level, const OwnRadii& own_radii,
                               const std::uint16_t* spacings, float* t_near) {
  const FaceLanes d;
  const auto* rows = &node.low[0][0];
  const auto grid_step =
      hn::Set(d, std::bit_cast<float>(static_cast<std::uint32_t>(127 + level - k_min_frame_level) << 23));
  const auto faces = [&](std::size_t lane) {
    auto t = hn::Zero(d), radius = hn::Zero(d);
    if constexpr (radii == Radii::own) radius = slot_radii(own_radii, spacings, lane);
    for (int axis = 0; axis < 3; ++axis) {
      const auto step = hn::Load(d, ray.step[axis] + lane);
      const auto base =
          hn::MulAdd(hn::Load(d, ray.extra[axis] + lane), grid_step,
                     hn::MulAdd(hn::Set(d, corner[axis]), step, hn::Load(d, ray.offset[axis] + lane)));
      auto on_axis = hn::MulAdd(rows_as_floats(rows + ray.near_row[axis], rows + ray.far_row[axis], lane),
                                hn::Mul(step, grid_step), base);
      if constexpr (radii == Radii::own) on_axis = hn::NegMulAdd(radius, hn::Set(d, ray.way[axis]), on_axis);
      t = axis == 0 ? on_axis : hn::Max(t, on_axis);
    }
    return t;
  };
  const ChildLanes half;
  const auto zero = hn::Zero(half);
  const auto compare = [&](auto enter, auto minus_leave, std::size_t lane) {
    hn::Store(hn::Abs(hn::Max(enter, zero)), half, t_near + lane);
    return mask_bits(half, hn::And(hn::Le(hn::Add(enter, minus_leave), zero),
                                   hn::And(hn::Le(minus_leave, hn::Set(half, -boxes.t_low)),
                                           hn::Le(enter, hn::Set(half, boxes.t_cut)))))
           << lane;
  };
#if HWY_TARGET == HWY_AVX3
  const auto t = faces(0);
  return compare(hn::LowerHalf(half, t), hn::UpperHalf(half, t), 0);
#else
  unsigned meets = 0;
  for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d))
    meets |= compare(faces(lane), faces(lane + k_node_width), lane);
  return meets;
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
