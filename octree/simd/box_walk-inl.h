// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_BOX_WALK_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_BOX_WALK_INL_H
#undef ALIDADE_SIMD_BOX_WALK_INL_H
#else
#define ALIDADE_SIMD_BOX_WALK_INL_H
#endif

#include <algorithm>
#include <bit>

#include "octree/simd/box_test-inl.h"
#include "octree/simd/lattice_box.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// A point as it is stored.
struct StoredPoint {
  LatticePosition position;
  std::uint32_t index;  ///< storage index
};

/// How many more than there are unpack() may overwrite.
constexpr std::size_t k_unpack_room = 16;

/// Unpacks those points of a leaf whose bits are set; how many.
HWY_INLINE std::size_t unpack(const TreeView& tree, const Leaf& leaf, std::uint32_t bits,
                              StoredPoint* points) {
  std::size_t count = 0;
  if (tree.positions && leaf.first >= tree.first_exact) {
    for (; bits != 0; bits &= bits - 1) {
      const std::uint32_t i = index_of_lowest_bit(bits);
      points[count++] = {position_of(tree, leaf, i), leaf.first + i};
    }
    return count;
  }
  // What position_of() does.
  static_assert(sizeof(StoredPoint) == 4 * sizeof(std::int32_t));
  const hn::CappedTag<std::int32_t, k_unpack_room> d;
  const hn::Rebind<std::uint16_t, decltype(d)> stored;
  const std::uint16_t* const coordinates = tree.coordinates + std::size_t{3} * leaf.first;
  const auto corner = [&](int axis) {
    return hn::Set(
        d, static_cast<std::int32_t>(static_cast<std::uint32_t>(tree.base[axis]) + leaf.corner[axis]));
  };
  const auto corner_x = corner(0), corner_y = corner(1), corner_z = corner(2);
  const std::uint32_t all_lanes = (1u << hn::Lanes(d)) - 1u;
  for (std::uint32_t first = 0; first < leaf.count; first += static_cast<std::uint32_t>(hn::Lanes(d))) {
    const std::uint32_t here = bits >> first & all_lanes;
    if (here == 0) continue;
    const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(here), static_cast<std::uint8_t>(here >> 8)};
    const Compressor compress(d, hn::LoadMaskBits(d, bytes));
    const auto on_axis = [&](int axis, const auto& origin) {
      const auto steps = hn::PromoteTo(d, hn::LoadU(stored, coordinates + axis * leaf.count + first));
      return compress(hn::Add(steps, origin));
    };
    const auto index = hn::Add(hn::Iota(d, 0), hn::Set(d, static_cast<std::int32_t>(leaf.first + first)));
    hn::StoreInterleaved4(on_axis(0, corner_x), on_axis(1, corner_y), on_axis(2, corner_z), compress(index),
                          d, reinterpret_cast<std::int32_t*>(points + count));
    count += static_cast<std::size_t>(std::popcount(here));
  }
  return count;
}

/// Hands leaves out with the points in a box, as bits. Visit: leaf(leaf, bits); all(frame, slot) -> whether
/// it needs no more of the points below, which are all inside.
template <class Visit>
class BoxWalk {
 public:
  BoxWalk(const TreeView& tree, const LatticeBox& box, int max_level, Visit& visit)
      : tree_(tree), box_(box), max_level_(max_level), visit_(visit) {}

  void run() { walk(root_frame(tree_), false); }

 private:
  void walk(const Frame& frame, bool is_inside) {
    const Node& node = tree_.nodes[frame.node];
    const Slots slots(node);
    unsigned met = 0xffff, inside = 0xffff;
    if (!is_inside) compare_boxes(frame, node, met, inside);
    if (frame.depth >= max_level_) met &= slots.leaf;
    met &= slots.leaf | slots.inner;
    for (; met != 0 && !visit_.is_done(); met &= met - 1) {
      const int slot = std::countr_zero(met);
      const bool child_inside = (inside >> slot & 1u) != 0;
      if (child_inside && visit_.all(frame, slot)) continue;
      if ((slots.leaf >> slot & 1u) != 0) {
        const Leaf leaf = slots.leaf_in(node, frame, slot);
        const std::uint32_t all = leaf.count == 32 ? ~0u : (1u << leaf.count) - 1u;
        const std::uint32_t points = child_inside ? all : compare_points(leaf, frame.level) & all;
        if (points != 0) visit_.leaf(leaf, points);
      } else {
        walk(slots.child_in(node, frame, slot), child_inside);
      }
    }
  }

  /// met: boxes that have a lattice step in common with the box; inside: that have no step outside.
  void compare_boxes(const Frame& frame, const Node& node, unsigned& met, unsigned& inside) const {
    const hn::CappedTag<std::uint8_t, k_node_width> d;
    const int shift = frame.level - k_min_frame_level;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t low = box_.low[axis] - frame.corner[axis],
                         high = box_.high[axis] - frame.corner[axis];
      // In grid steps of the frame; shifts round down. [first, last] are touched, [first_full, last_full]
      // covered.
      const std::int64_t first = low >> shift, last = high >> shift,
                         first_full = (low + (std::int64_t{1} << shift) - 1) >> shift,
                         last_full = ((high + 1) >> shift) - 1;
      if (last < 0 || first > 255) met = 0;
      if (last_full < 0 || first_full > 255) inside = 0;
      const auto byte = [&](std::int64_t step) {
        return hn::Set(d, static_cast<std::uint8_t>(std::clamp<std::int64_t>(step, 0, 255)));
      };
      const auto touched_first = byte(first), touched_last = byte(last), full_first = byte(first_full),
                 full_last = byte(last_full);
      unsigned met_here = 0, inside_here = 0;
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        const auto box_low = hn::LoadU(d, node.low[axis] + lane),
                   box_high = hn::LoadU(d, node.high[axis] + lane);
        const auto meets = hn::And(hn::Eq(hn::Max(box_high, touched_first), box_high),
                                   hn::Eq(hn::Min(box_low, touched_last), box_low));
        const auto stays = hn::And(hn::Eq(hn::Max(box_low, full_first), box_low),
                                   hn::Eq(hn::Min(box_high, full_last), box_high));
        met_here |= byte_mask_bits(d, meets) << lane;
        inside_here |= byte_mask_bits(d, stays) << lane;
      }
      met &= met_here;
      inside &= inside_here;
    }
  }

  /// Bit per point: inside. Bits past the leaf's count are undefined.
  std::uint32_t compare_points(const Leaf& leaf, int level) const {
    std::uint32_t points = 0;
    if (coordinate_shift(level) > 0) {
      for (std::uint32_t i = 0; i < leaf.count; ++i)
        points |= box_.contains(position_of(tree_, leaf, i), tree_.base) ? 1u << i : 0u;
      return points;
    }
    const hn::CappedTag<std::uint16_t, 16> d;
    const std::uint16_t* const coordinates = tree_.coordinates + std::size_t{3} * leaf.first;
    points = ~0u;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t low = box_.low[axis] - leaf.corner[axis], high = box_.high[axis] - leaf.corner[axis];
      if (high < 0 || low > 0xffff) return 0;
      const auto first = hn::Set(d, static_cast<std::uint16_t>(std::max<std::int64_t>(low, 0))),
                 last = hn::Set(d, static_cast<std::uint16_t>(std::min<std::int64_t>(high, 0xffff)));
      std::uint32_t here = 0;
      for (std::size_t i = 0; i < leaf.count; i += hn::Lanes(d)) {
        const auto value = hn::LoadU(d, coordinates + axis * leaf.count + i);
        const auto stays = hn::And(hn::Eq(hn::Max(value, first), value), hn::Eq(hn::Min(value, last), value));
        here |= byte_mask_bits(d, stays) << i;
      }
      points &= here;
    }
    return points;
  }

  const TreeView& tree_;
  const LatticeBox& box_;
  const int max_level_;
  Visit& visit_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
