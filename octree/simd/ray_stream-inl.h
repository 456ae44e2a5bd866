// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_STREAM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_STREAM_INL_H
#undef ALIDADE_SIMD_RAY_STREAM_INL_H
#else
#define ALIDADE_SIMD_RAY_STREAM_INL_H
#endif

#include <hwy/cache_control.h>

#include <algorithm>
#include <vector>

#include "octree/simd/front_to_back.h"
#include "octree/simd/ray_traversal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Many rays of one octant through the tree together: every node is read once for all rays that meet it, its
/// boxes are turned into floats once, and the rays' tests do not wait for one another. Where fewer than
/// k_min_rays are left, each goes on alone.
template <Measure measure, bool any>
class RayStream {
 public:
  RayStream(const QuerySetup& setup, const LeafTest<measure, any>& leaf_test,
            const RayTraversal<measure, any>& alone)
      : setup_(setup), leaf_test_(leaf_test), alone_(alone) {}

  /// rays: numbers into states, all of this octant, none with misses or exhaustive.
  void run(std::span<RayState> states, std::vector<std::uint32_t>& rays, unsigned octant) {
    states_ = states;
    octant_ = octant;
    if (lists_.empty()) lists_.resize(k_max_tree_depth + 1);
    const auto count = static_cast<std::uint32_t>(rays.size());
    List& list = lists_[0];
    list.reserve(count);
    std::ranges::copy(rays, list.rays.begin());
    visit_node(root_visit(setup_.tree), count);
  }

 private:
  static constexpr std::uint32_t k_min_rays = 3;
  static constexpr std::uint32_t k_padding = 64;

  /// The rays that meet a node, and what they meet of it.
  struct List {
    std::vector<std::uint32_t> rays;     ///< numbers into states_
    std::vector<std::uint8_t> met;       ///< slots as bits
    std::vector<float> t_near;           ///< eight per ray
    std::vector<std::uint32_t> in_slot;  ///< numbers into rays

    void reserve(std::size_t count) {
      if (rays.size() >= count + k_padding) return;
      rays.resize(count + k_padding);
      met.resize(count + k_padding);
      t_near.resize(8 * (count + k_padding));
      in_slot.resize(count + k_padding);
    }
  };

  void visit_node(const Visit& visit, std::uint32_t count) {
    List& list = lists_[visit.depth];
    if (count < k_min_rays) {
      for (std::uint32_t i = 0; i < count; ++i) alone_.run(states_[list.rays[i]], visit);
      return;
    }
    const Node& node = setup_.tree.nodes[visit.node];
    const Slots slots(node);
    const unsigned met = meet_boxes(node, visit, list, count);
    unsigned single = 0, wanted = met & (visit.depth < alone_.max_depth() ? 0xffu : slots.leaf);
    if (visit.level == k_min_frame_level && alone_.skips_twins()) {
      const Places places(node);
      wanted &= ~places.twins;
      single = places.single;
    }
    wanted &= slots.leaf | slots.inner;
    for (unsigned rest = wanted; rest != 0; rest &= rest - 1) {
      const int slot = std::countr_zero(rest);
      if ((slots.leaf >> slot & 1u) != 0) {
        const std::uint16_t* coordinates =
            setup_.tree.coordinates + std::size_t{3} * slots.first_point(node, slot);
        for (int line = 0; line < 3; ++line) hwy::Prefetch(coordinates + 32 * line);
      } else {
        hwy::Prefetch(setup_.tree.nodes + slots.child(node, slot));
      }
    }
    const SlotOrder order = front_to_back(node, octant_, wanted);
    for (int place = 0; place < order.count; ++place) {
      const int slot = order.slot[place];
      const std::uint32_t in_slot = gather_slot(list, count, slot);
      if (in_slot == 0) continue;
      if ((slots.leaf >> slot & 1u) != 0) {
        const std::uint32_t points = node.kind[slot];
        const Leaf leaf{
            slots.first_point(node, slot), points, {visit.corner[0], visit.corner[1], visit.corner[2]}};
        const std::uint32_t tested = (single >> slot & 1u) != 0 ? 1u : points;
        for (std::uint32_t i = 0; i < in_slot; ++i) {
          const std::uint32_t number = list.in_slot[i];
          RayState& state = states_[list.rays[number]];
          if (list.t_near[8 * std::size_t{number} + slot] <= state.t_cut)
            leaf_test_.visit(state, leaf, tested, visit.level);
        }
      } else {
        List& next = lists_[visit.depth + 1];
        next.reserve(in_slot);
        std::uint32_t next_count = 0;
        float nearest = std::numeric_limits<float>::infinity();
        for (std::uint32_t i = 0; i < in_slot; ++i) {
          const std::uint32_t number = list.in_slot[i];
          const std::uint32_t ray = list.rays[number];
          const float t_near = list.t_near[8 * std::size_t{number} + slot];
          next.rays[next_count] = ray;
          next_count += t_near <= states_[ray].t_cut ? 1u : 0u;
          nearest = std::min(nearest, t_near);
        }
        if (next_count == 0) continue;
        const int drop = node.kind[slot] - k_inner_kind;
        Visit child;
        child.t_near = nearest;
        child.node = slots.child(node, slot);
        for (int axis = 0; axis < 3; ++axis)
          child.corner[axis] = visit.corner[axis] + child_corner(node.low[axis][slot], visit.level, drop);
        child.level = static_cast<std::uint16_t>(visit.level - drop);
        child.depth = static_cast<std::uint16_t>(visit.depth + 1);
        visit_node(child, next_count);
      }
    }
  }

  /// Numbers of the rays that meet a slot, to list.in_slot.
  static std::uint32_t gather_slot(List& list, std::uint32_t count, int slot) {
    const hn::CappedTag<std::uint32_t, 16> d;
    const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
    const auto bit = hn::Set(d, 1u << slot);
    std::uint32_t in_slot = 0;
    for (std::uint32_t i = 0; i < count; i += lanes) {
      const auto met =
          hn::PromoteTo(d, hn::LoadU(hn::Rebind<std::uint8_t, decltype(d)>(), list.met.data() + i));
      in_slot += static_cast<std::uint32_t>(
          hn::CompressStore(hn::Iota(d, i), hn::TestBit(met, bit), d, list.in_slot.data() + in_slot));
    }
    return in_slot;
  }

  /// Fills met and t_near of the list; all slots that any ray meets, empty ones included.
  unsigned meet_boxes(const Node& node, const Visit& visit, List& list, std::uint32_t count) {
    const ChildLanes d;
    alignas(64) float faces[6][k_node_width];
    const auto grid_step = static_cast<float>(power_of_two(visit.level - k_min_frame_level));
    const auto reach = static_cast<float>(setup_.box_radius + setup_.stream_error);
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = (octant_ >> axis & 1) != 0;
      const float corner = static_cast<float>(static_cast<std::int32_t>(visit.corner[axis] >> 8)) * 256.0f *
                           setup_.float_scale[axis];
      const float step = grid_step * setup_.float_scale[axis];
      const float low_base = corner - reach, high_base = corner + (step + reach);
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        const auto low =
            hn::MulAdd(load_as_float(d, node.low[axis] + lane), hn::Set(d, step), hn::Set(d, low_base));
        const auto high =
            hn::MulAdd(load_as_float(d, node.high[axis] + lane), hn::Set(d, step), hn::Set(d, high_base));
        hn::Store(negative ? high : low, d, faces[axis] + lane);
        hn::Store(negative ? low : high, d, faces[3 + axis] + lane);
      }
    }
    unsigned all = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const RayState& state = states_[list.rays[i]];
      hwy::Prefetch(&states_[list.rays[i + 8 < count ? i + 8 : i]]);
      unsigned met = 0;
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        const auto face = [&](int row) {
          const int axis = row % 3;
          return hn::MulSub(hn::Load(d, faces[row] + lane), hn::Set(d, state.inverse[axis]),
                            hn::Set(d, state.origin_t[axis]));
        };
        const auto enter = hn::Max(hn::Max(face(0), face(1)), face(2));
        const auto leave = hn::Min(hn::Min(face(3), face(4)), face(5));
        hn::StoreU(enter, d, list.t_near.data() + 8 * std::size_t{i} + lane);
        const auto meets = hn::And(hn::And(hn::Le(enter, leave), hn::Ge(leave, hn::Set(d, state.t_low))),
                                   hn::Le(enter, hn::Set(d, state.t_cut)));
        met |= mask_bits(d, meets) << lane;
      }
      list.met[i] = static_cast<std::uint8_t>(met);
      all |= met;
    }
    // What the compression reads past the end.
    std::fill_n(list.met.begin() + count, 16, std::uint8_t{0});
    return all;
  }

  const QuerySetup& setup_;
  const LeafTest<measure, any>& leaf_test_;
  const RayTraversal<measure, any>& alone_;
  std::span<RayState> states_;
  unsigned octant_ = 0;
  std::vector<List> lists_;  ///< by depth
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
