// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_RAY_STREAM_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_RAY_STREAM_INL_H
#undef ALIDADE_SIMD_RAY_STREAM_INL_H
#else
#define ALIDADE_SIMD_RAY_STREAM_INL_H
#endif

#include <hwy/cache_control.h>

#include <memory>
#include <span>
#include <vector>

#include "octree/simd/leaf_group_test-inl.h"
#include "octree/simd/ray_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Traverses the tree with many rays of one octant (signs of their directions) together, one lane per ray:
/// each node is read once for all rays that meet it, and its boxes, or the points of a leaf, are converted to
/// floats once. Where few rays are left, each continues alone.
template <class Points, bool any>
class RayStream {
 public:
  explicit RayStream(const Traversed<Points, any>& traversed)
      : traversed_(traversed), setup_(traversed.setup) {}

  /// rays: their numbers in the batch, all of the octant. The k_list_padding elements behind them are
  /// overwritten.
  void run(const RayBatch& batch, std::span<std::uint32_t> rays, unsigned octant) {
    batch_ = batch;
    octant_ = octant;
    if (lists_.empty()) lists_.resize(k_max_tree_depth + 1);
    RayList list{rays.data(), nullptr, static_cast<std::uint32_t>(rays.size())};
    list.pad();
    visit_node(root_frame(setup_.tree), list);
  }

 private:
  static constexpr std::uint32_t k_min_rays_at_node = 4;  ///< fewer continue alone

  /// Memory for k_node_width lists of rays: those that meet each slot of a node.
  struct Lists {
    std::unique_ptr<std::uint32_t[]> rays;
    std::unique_ptr<float[]> t_near;
    std::size_t capacity = 0;  ///< of each list

    /// For `count` rays in each list. Contents are lost.
    void reserve(std::size_t count) {
      if (capacity >= count + k_list_padding) return;
      capacity = count + k_list_padding;
      rays = std::make_unique_for_overwrite<std::uint32_t[]>(k_node_width * capacity);
      t_near = std::make_unique_for_overwrite<float[]>(k_node_width * capacity);
    }
    /// An empty list in the memory of this number.
    RayList list(std::size_t number) const {
      return {rays.get() + number * capacity, t_near.get() + number * capacity, 0};
    }
  };

  /// Faces of the boxes of a node's slots, widened by the radius: metres from the setup's corner. The rays
  /// meet `near` first and `far` last.
  struct Faces {
    alignas(64) float near[3][k_node_width], far[3][k_node_width];
  };

  void visit_node(const Frame& frame, const RayList& list) {
    if (list.count < k_min_rays_at_node) {
      trace_each(frame, list);
      return;
    }
    const Node& node = setup_.tree.nodes[frame.node];
    const Slots slots(node);
    // Sets of slots (bits): those to visit, and leaves whose points have equal positions, so that only the
    // first is tested.
    unsigned wanted = slots.leaf | (frame.depth < traversed_.max_depth ? slots.inner : 0u), single = 0;
    if (frame.level == k_min_frame_level && (traversed_.skips_twins || traversed_.rejects_twins)) {
      const SamePositions same(node);
      if (traversed_.skips_twins) {
        wanted &= ~same.twins;
        single = same.single;
      } else if (traversed_.has_twins(slots, same)) {
        trace_each(frame, list);
        return;
      }
    }
    Lists& lists = lists_[frame.depth];
    lists.reserve(list.count);
    RayList met[k_node_width];
    unsigned next_list = 0;
    for (unsigned rest = wanted; rest != 0; rest &= rest - 1)
      met[std::countr_zero(rest)] = lists.list(next_list++);
    const Faces faces = faces_of(node, frame);
    constexpr std::uint32_t k_few_rays = 8;
    if (list.count <= k_few_rays) {
      meet_boxes_in_lanes(faces, list, wanted, met);
    } else {
      meet_rays_in_lanes(faces, list, wanted, met);
    }
    unsigned met_slots = 0;
    for (unsigned rest = wanted; rest != 0; rest &= rest - 1) {
      const int slot = std::countr_zero(rest);
      if (met[slot].count == 0) continue;
      met_slots |= 1u << slot;
      met[slot].pad();
      if ((slots.leaf >> slot & 1u) != 0) {
        traversed_.leaf_test.fetch(slots.first_point(node, slot), node.kind[slot]);
      } else {
        hwy::Prefetch(setup_.tree.nodes + slots.child(node, slot));
        hwy::Prefetch(&setup_.tree.nodes[slots.child(node, slot)].high[1]);
      }
    }
    const SlotOrder order = front_to_back(node, octant_, met_slots);
    const std::uint64_t tests_before = tests_;
    const auto leaf_frame = traversed_.leaf_test.leaf_frame(frame.corner, frame.level);
    for (int i = 0; i < order.count; ++i) {
      const int slot = order.slot[i];
      RayList& rays = met[slot];
      if (tests_ != tests_before) rays.discard(batch_.boxes);
      if (rays.count == 0) continue;
      if ((slots.leaf >> slot & 1u) != 0) {
        const Leaf leaf = slots.leaf_in(node, frame, slot);
        test_leaf(setup_, traversed_.leaf_test, leaf, (single >> slot & 1u) != 0 ? 1u : leaf.count,
                  leaf_frame, batch_, rays, tests_);
      } else {
        visit_node(slots.child_in(node, frame, slot), rays);
      }
    }
  }

  void trace_each(const Frame& frame, const RayList& list) {
    for (std::uint32_t i = 0; i < list.count; ++i) trace(traversed_, batch_[list.rays[i]], frame);
    ++tests_;
  }

  Faces faces_of(const Node& node, const Frame& frame) const {
    const ChildLanes d;
    Faces faces;
    const auto grid_step = static_cast<float>(power_of_two(frame.level - k_min_frame_level));
    const auto margin = static_cast<float>(setup_.widening(frame.corner, frame.level));
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = (octant_ >> axis & 1) != 0;
      const float corner = setup_.steps_to(frame.corner[axis], axis) * setup_.tree.extent.scale[axis];
      const float step = grid_step * setup_.tree.extent.scale[axis];
      const float low_base = corner - margin, high_base = corner + (step + margin);
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        auto low =
            hn::MulAdd(load_as_float(d, node.low[axis] + lane), hn::Set(d, step), hn::Set(d, low_base));
        auto high =
            hn::MulAdd(load_as_float(d, node.high[axis] + lane), hn::Set(d, step), hn::Set(d, high_base));
        if constexpr (Points::own_radii) {
          const auto radius = traversed_.leaf_test.points().slot_reach(d, frame.node, axis, lane);
          low = hn::Sub(low, radius);
          high = hn::Add(high, radius);
        }
        hn::Store(negative ? high : low, d, faces.near[axis] + lane);
        hn::Store(negative ? low : high, d, faces.far[axis] + lane);
      }
    }
    return faces;
  }

  /// Appends rays to the lists in `met` of those `wanted` slots (bits) whose boxes they meet. One lane per
  /// slot: faster for few rays.
  void meet_boxes_in_lanes(const Faces& faces, const RayList& list, unsigned wanted, RayList* met) const {
    const ChildLanes d;
    for (std::uint32_t i = 0; i < list.count; ++i) {
      const std::uint32_t number = list.rays[i];
      const RayBoxes& ray = batch_.boxes[number];
      alignas(64) float enters[k_node_width];
      unsigned meets = 0;
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        auto enter = hn::Zero(d), leave = hn::Set(d, ray.t_cut);
        for (int axis = 0; axis < 3; ++axis) {
          const auto inverse = hn::Set(d, ray.inverse[axis]), origin_t = hn::Set(d, ray.origin_t[axis]);
          enter = hn::Max(enter, hn::MulSub(hn::Load(d, faces.near[axis] + lane), inverse, origin_t));
          leave = hn::Min(leave, hn::MulSub(hn::Load(d, faces.far[axis] + lane), inverse, origin_t));
        }
        hn::Store(enter, d, enters + lane);
        meets |= mask_bits(d, hn::Le(enter, leave)) << lane;
      }
      for (meets &= wanted; meets != 0; meets &= meets - 1) {
        const int slot = std::countr_zero(meets);
        RayList& rays = met[slot];
        rays.rays[rays.count] = number;
        rays.t_near[rays.count++] = enters[slot];
      }
    }
  }

  /// As meet_boxes_in_lanes(), with one lane per ray: faster for many rays.
  void meet_rays_in_lanes(const Faces& faces, const RayList& list, unsigned wanted, RayList* met) const {
    const RayLanes d;
    const RayNumbers n;
    for (std::uint32_t i = 0; i < list.count; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
      const RayGroup ray(batch_.boxes, list.rays + i, list.count - i);
      const auto numbers = hn::LoadU(n, list.rays + i);
      const auto zero = hn::Zero(d);
      for (unsigned rest = wanted; rest != 0; rest &= rest - 1) {
        const int slot = std::countr_zero(rest);
        const auto t = [&](int axis, float face) {
          return hn::MulSub(hn::Set(d, face), ray.inverse[axis], ray.origin_t[axis]);
        };
        const auto enter =
            hn::Max(hn::Max(t(0, faces.near[0][slot]), t(1, faces.near[1][slot])), t(2, faces.near[2][slot]));
        const auto leave =
            hn::Min(hn::Min(t(0, faces.far[0][slot]), t(1, faces.far[1][slot])), t(2, faces.far[2][slot]));
        const auto meets =
            hn::And(hn::Le(enter, leave), hn::And(hn::Ge(leave, zero), hn::Le(enter, ray.t_cut)));
        if (!hn::AllFalse(d, meets)) met[slot].add(numbers, enter, meets);
      }
    }
  }

  const Traversed<Points, any>& traversed_;
  const QuerySetup& setup_;
  RayBatch batch_{};
  unsigned octant_ = 0;
  std::uint64_t tests_ = 0;   ///< changes when rays may have found nearer points
  std::vector<Lists> lists_;  ///< by depth
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
