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
class Slots {
 public:
  unsigned inner;  ///< bit per slot
  unsigned leaf;   ///< bit per slot

#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128
  explicit Slots(const Node& node) : inner(inner_slots(node)), leaf(0), counts_(leaf_counts(node)) {
    leaf = counts_.nonzero();
  }
#else
  explicit Slots(const Node& node) {
    const hn::Full128<std::int8_t> d;
    const auto kinds = hn::Load(d, reinterpret_cast<const std::int8_t*>(node.kind));
    // Kinds of inner children are negative, read with a sign.
    const auto counts = hn::Max(kinds, hn::Zero(d));
    inner = byte_mask_bits(d, hn::Lt(kinds, hn::Zero(d)));
    leaf = byte_mask_bits(d, hn::Gt(counts, hn::Zero(d)));
    counts_ = hn::BitCast(hn::Full128<std::uint8_t>(), counts);
  }
#endif

  HWY_INLINE std::uint32_t first_point(const Node& node, int slot) const {
    return node.first_point + sum_before(slot);
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

 private:
  /// Points of the leaves before a slot.
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128
  std::uint32_t sum_before(int slot) const {
    return counts_.sum_before(slot);
  }
  SlotBytes counts_;
#else
  HWY_INLINE std::uint32_t sum_before(int slot) const {
    const hn::Full128<std::uint8_t> d;
    const auto before = hn::IfThenElseZero(hn::FirstN(d, static_cast<std::size_t>(slot)), counts_);
    alignas(16) std::uint64_t sums[2];
    hn::Store(hn::SumsOf8(before), hn::Full128<std::uint64_t>(), sums);
    return static_cast<std::uint32_t>(sums[0] + sums[1]);
  }
  hn::Vec<hn::Full128<std::uint8_t>> counts_;
#endif
};

/// Slots of a node at the lowest level whose points all have equal positions. Boxes are exact there, and ids
/// rise from point to point and from slot to slot of one position (Node in octree/octree.h); so only the
/// first point of the first such slot can be the answer to `closest` without a filter and with all levels.
/// This keeps a ray through a million equal points from testing each.
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

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
