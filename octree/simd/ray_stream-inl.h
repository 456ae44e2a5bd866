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
#include <memory>
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
  explicit RayStream(const Traversed<measure, any>& traversed)
      : traversed_(traversed), setup_(traversed.setup) {}

  /// rays: numbers into boxes and states, all of this octant.
  void run(std::span<RayBoxes> boxes, std::span<RayState> states, std::span<const std::uint32_t> rays,
           unsigned octant) {
    boxes_ = boxes;
    states_ = states;
    octant_ = octant;
    if (lists_.empty()) lists_.resize(k_max_tree_depth + 1);
    const auto count = static_cast<std::uint32_t>(rays.size());
    List& list = lists_[0];
    list.reserve(count);
    std::ranges::copy(rays, list.rays.get());
    visit_node(root_visit(setup_.tree), count);
  }

 private:
  static constexpr std::uint32_t k_min_rays = 3;
  static constexpr std::uint32_t k_padding = 64;

  /// The rays that meet a node, and what they meet of it.
  struct List {
    std::unique_ptr<std::uint32_t[]> rays;     ///< numbers into boxes_ and states_
    std::unique_ptr<std::uint8_t[]> met;       ///< slots as bits
    std::unique_ptr<float[]> t_near;           ///< eight per ray
    std::unique_ptr<std::uint32_t[]> in_slot;  ///< numbers into rays
    std::size_t room = 0;

    void reserve(std::size_t count) {
      if (room >= count) return;
      room = count;
      rays = std::make_unique_for_overwrite<std::uint32_t[]>(count + k_padding);
      met = std::make_unique_for_overwrite<std::uint8_t[]>(count + k_padding);
      t_near = std::make_unique_for_overwrite<float[]>(8 * (count + k_padding));
      in_slot = std::make_unique_for_overwrite<std::uint32_t[]>(count + k_padding);
    }
  };

  void visit_node(const Visit& visit, std::uint32_t count) {
    List& list = lists_[visit.depth];
    if (count < k_min_rays) {
      for (std::uint32_t i = 0; i < count; ++i)
        trace(traversed_, boxes_[list.rays[i]], states_[list.rays[i]], visit);
      return;
    }
    const Node& node = setup_.tree.nodes[visit.node];
    const Slots slots(node);
    const unsigned met = meet_boxes(node, visit, list, count);
    unsigned single = 0, wanted = met & (visit.depth < traversed_.max_depth ? 0xffu : slots.leaf);
    if (visit.level == k_min_frame_level && traversed_.skips_twins) {
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
    const auto leaf_place = traversed_.leaf_test.place(visit.corner, visit.level);
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
          const std::uint32_t ray = list.rays[number];
          if (list.t_near[8 * std::size_t{number} + slot] <= boxes_[ray].t_cut)
            traversed_.leaf_test.visit(boxes_[ray], states_[ray], leaf, tested, leaf_place);
        }
      } else {
        List& next = lists_[visit.depth + 1];
        next.reserve(in_slot);
        std::uint32_t next_count = 0;
        for (std::uint32_t i = 0; i < in_slot; ++i) {
          const std::uint32_t number = list.in_slot[i];
          const std::uint32_t ray = list.rays[number];
          next.rays[next_count] = ray;
          next_count += list.t_near[8 * std::size_t{number} + slot] <= boxes_[ray].t_cut ? 1u : 0u;
        }
        if (next_count != 0) visit_node(child_visit(visit, node, slots.child(node, slot), slot), next_count);
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
          hn::PromoteTo(d, hn::LoadU(hn::Rebind<std::uint8_t, decltype(d)>(), list.met.get() + i));
      const auto meets = hn::TestBit(met, bit);
      // A whole vector at a time: what stands past the count is written over or is padding.
      hn::StoreU(hn::Compress(hn::Iota(d, i), meets), d, list.in_slot.get() + in_slot);
      in_slot += static_cast<std::uint32_t>(hn::CountTrue(d, meets));
    }
    return in_slot;
  }

  /// Fills met and t_near of the list; all slots that any ray meets, empty ones included.
  unsigned meet_boxes(const Node& node, const Visit& visit, List& list, std::uint32_t count) {
    const ChildLanes d;
    alignas(64) float faces[6][k_node_width];
    const auto grid_step = static_cast<float>(power_of_two(visit.level - k_min_frame_level));
    const auto reach = static_cast<float>(setup_.box_radius);
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
      const RayBoxes& ray = boxes_[list.rays[i]];
      unsigned met = 0;
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        const auto face = [&](int row) {
          const int axis = row % 3;
          return hn::MulSub(hn::Load(d, faces[row] + lane), hn::Set(d, ray.inverse[axis]),
                            hn::Set(d, ray.origin_t[axis]));
        };
        const auto enter = hn::Max(hn::Max(face(0), face(1)), face(2));
        const auto leave = hn::Min(hn::Min(face(3), face(4)), face(5));
        hn::StoreU(enter, d, list.t_near.get() + 8 * std::size_t{i} + lane);
        const auto meets = hn::And(hn::And(hn::Le(enter, leave), hn::Ge(leave, hn::Set(d, ray.t_low))),
                                   hn::Le(enter, hn::Set(d, ray.t_cut)));
        met |= mask_bits(d, meets) << lane;
      }
      list.met[i] = static_cast<std::uint8_t>(met);
      all |= met;
    }
    // What the compression reads past the end.
    std::fill_n(list.met.get() + count, 16, std::uint8_t{0});
    return all;
  }

  const Traversed<measure, any>& traversed_;
  const QuerySetup& setup_;
  std::span<RayBoxes> boxes_;
  std::span<RayState> states_;
  unsigned octant_ = 0;
  std::vector<List> lists_;  ///< by depth
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
