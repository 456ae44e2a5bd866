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
#include <new>
#include <span>
#include <vector>

#include "octree/simd/leaf_group_test-inl.h"
#include "octree/simd/ray_state.h"
#include "octree/simd/ray_traversal-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Many rays, a few of them under way at a time by turns: while one does its step, the memory that the others
/// need next is on its way to the processor. For rays that have little of the tree in common.
/// rays: numbers in the batch.
template <Measure measure, bool any, Radii radii>
void trace_interleaved(const Traversed<measure, any, radii>& traversed, const RayBatch& batch,
                       std::span<const std::uint32_t> rays) {
  using Walk = RayWalk<measure, any, radii>;
  constexpr std::size_t k_under_way = 12;
  struct Turn {
    alignas(Walk) std::byte walk[sizeof(Walk)];
    bool has_leaves = false;
  };
  const auto turns = std::make_unique_for_overwrite<Turn[]>(k_under_way);
  const auto walk_of = [](Turn& turn) { return std::launder(reinterpret_cast<Walk*>(turn.walk)); };
  const Visit root = root_visit(traversed.setup.tree);
  std::size_t next = 0, active = 0;
  const auto start = [&](Turn& turn) {
    new (turn.walk) Walk(traversed, batch[rays[next++]], root);
    turn.has_leaves = false;
  };
  while (active < k_under_way && next < rays.size()) start(turns[active++]);
  while (active > 0) {
    for (std::size_t i = 0; i < active;) {
      Turn& turn = turns[i];
      Walk& walk = *walk_of(turn);
      if (!turn.has_leaves && walk.look(traversed)) {
        walk.prefetch_leaves(traversed);
        turn.has_leaves = true;
        ++i;
        continue;
      }
      if (turn.has_leaves) walk.test_leaves(traversed);
      turn.has_leaves = false;
      if (walk.go_on(traversed)) {
        walk.prefetch_node(traversed);
        ++i;
      } else if (next < rays.size()) {
        start(turn);
        ++i;
      } else {
        --active;
        if (i != active) turn = turns[active];
      }
    }
  }
}

/// Many rays of one octant through the tree together, one lane per ray: every node is read once for all rays
/// that meet it, its boxes are turned into floats once, and so are the points of leaves. Where few are left,
/// each goes on alone.
template <Measure measure, bool any, Radii radii>
class RayStream {
 public:
  explicit RayStream(const Traversed<measure, any, radii>& traversed)
      : traversed_(traversed), setup_(traversed.setup) {}

  /// rays: numbers in the batch, all of this octant; k_list_padding more may be written over.
  void run(const RayBatch& batch, std::span<std::uint32_t> rays, unsigned octant) {
    batch_ = batch;
    octant_ = octant;
    if (lists_.empty()) lists_.resize(k_max_tree_depth + 1);
    RayList list{rays.data(), nullptr, static_cast<std::uint32_t>(rays.size())};
    list.pad();
    visit_node(root_visit(setup_.tree), list);
  }

 private:
  static constexpr std::uint32_t k_min_rays = 4;  ///< at a node
  static constexpr std::uint32_t k_min_rays_at_leaf = 3;

  /// Room for the rays that meet each slot of a node.
  struct Lists {
    std::unique_ptr<std::uint32_t[]> rays;
    std::unique_ptr<float[]> t_near;
    std::size_t room = 0;

    void reserve(std::size_t count) {
      if (room >= count + k_list_padding) return;
      room = count + k_list_padding;
      rays = std::make_unique_for_overwrite<std::uint32_t[]>(k_node_width * room);
      t_near = std::make_unique_for_overwrite<float[]>(k_node_width * room);
    }
    RayList list(std::size_t place) const {
      return {rays.get() + place * room, t_near.get() + place * room, 0};
    }
  };

  /// Faces of a node's boxes, widened, from the root's corner, metres; first met, last met.
  struct Faces {
    float near[3][k_node_width], far[3][k_node_width];
  };

  void visit_node(const Visit& visit, const RayList& list) {
    if (list.count < k_min_rays) {
      for (std::uint32_t i = 0; i < list.count; ++i) trace(traversed_, batch_[list.rays[i]], visit);
      ++answers_;
      return;
    }
    const Node& node = setup_.tree.nodes[visit.node];
    const Slots slots(node);
    unsigned single = 0, wanted = slots.leaf | (visit.depth < traversed_.max_depth ? slots.inner : 0u);
    if (visit.level == k_min_frame_level && traversed_.skips_twins) {
      const Places places(node);
      wanted &= ~places.twins;
      single = places.single;
    }
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
    Lists& lists = lists_[visit.depth];
    lists.reserve(list.count);
    RayList met[k_node_width];
    for (int place = 0; place < order.count; ++place)
      met[place] = lists.list(static_cast<std::size_t>(place));
    meet_boxes(node, visit, list, order, met);
    const std::uint64_t answers_before = answers_;
    const auto leaf_place = traversed_.leaf_test.place(visit.corner, visit.level);
    for (int place = 0; place < order.count; ++place) {
      const int slot = order.slot[place];
      if (met[place].count == 0) continue;
      if (answers_ != answers_before) met[place].discard(batch_.boxes);
      if (met[place].count == 0) continue;
      if ((slots.leaf >> slot & 1u) != 0) {
        const std::uint32_t points = node.kind[slot];
        const Leaf leaf{
            slots.first_point(node, slot), points, {visit.corner[0], visit.corner[1], visit.corner[2]}};
        test_leaf(leaf, (single >> slot & 1u) != 0 ? 1u : points, leaf_place, met[place]);
      } else {
        visit_node(child_visit(visit, node, slots.child(node, slot), slot), met[place]);
      }
    }
  }

  void test_leaf(const Leaf& leaf, std::uint32_t count,
                 const typename LeafTest<measure, any, radii>::Place& place, const RayList& list) {
    if (list.count >= k_min_rays_at_leaf && !traversed_.leaf_test.all_in_double()) {
      LeafGroupTest<measure, any, radii>(setup_, traversed_.leaf_test, leaf, count, place)
          .visit(batch_, list, answers_);
      return;
    }
    for (std::uint32_t i = 0; i < list.count; ++i)
      traversed_.leaf_test.visit(batch_[list.rays[i]], leaf, count, place, list.t_near[i]);
    ++answers_;
  }

  Faces faces_of(const Node& node, const Visit& visit) const {
    const ChildLanes d;
    Faces faces;
    const auto grid_step = static_cast<float>(power_of_two(visit.level - k_min_frame_level));
    const auto margin = static_cast<float>(radii == Radii::own ? setup_.box_margin : setup_.box_radius);
    const OwnRadii& own_radii = traversed_.leaf_test.own_radii();
    const std::uint16_t* spacings = slot_spacings(setup_.tree, visit.node);
    for (int axis = 0; axis < 3; ++axis) {
      const bool negative = (octant_ >> axis & 1) != 0;
      const float corner = static_cast<float>(static_cast<std::int32_t>(visit.corner[axis] >> 8)) * 256.0f *
                           setup_.float_scale[axis];
      const float step = grid_step * setup_.float_scale[axis];
      const float low_base = corner - margin, high_base = corner + (step + margin);
      for (std::size_t lane = 0; lane < k_node_width; lane += hn::Lanes(d)) {
        auto low =
            hn::MulAdd(load_as_float(d, node.low[axis] + lane), hn::Set(d, step), hn::Set(d, low_base));
        auto high =
            hn::MulAdd(load_as_float(d, node.high[axis] + lane), hn::Set(d, step), hn::Set(d, high_base));
        if constexpr (radii == Radii::own) {
          const auto radius = own_radii.above(d, spacings + lane);
          low = hn::Sub(low, radius);
          high = hn::Add(high, radius);
        }
        hn::StoreU(negative ? high : low, d, faces.near[axis] + lane);
        hn::StoreU(negative ? low : high, d, faces.far[axis] + lane);
      }
    }
    return faces;
  }

  /// Fills `met`, one list per slot in the order of `order`.
  void meet_boxes(const Node& node, const Visit& visit, const RayList& list, const SlotOrder& order,
                  RayList* met) const {
    const RayLanes d;
    const RayNumbers n;
    const Faces faces = faces_of(node, visit);
    for (std::uint32_t i = 0; i < list.count; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
      const RayGroup ray(batch_.boxes, list.rays + i, list.count - i);
      const auto numbers = hn::LoadU(n, list.rays + i);
      for (int place = 0; place < order.count; ++place) {
        const int slot = order.slot[place];
        const auto t = [&](int axis, float face) {
          return hn::MulSub(hn::Set(d, face), ray.inverse[axis], ray.origin_t[axis]);
        };
        const auto enter =
            hn::Max(hn::Max(t(0, faces.near[0][slot]), t(1, faces.near[1][slot])), t(2, faces.near[2][slot]));
        const auto leave =
            hn::Min(hn::Min(t(0, faces.far[0][slot]), t(1, faces.far[1][slot])), t(2, faces.far[2][slot]));
        const auto meets =
            hn::And(hn::Le(enter, leave), hn::And(hn::Ge(leave, ray.t_low), hn::Le(enter, ray.t_cut)));
        if (!hn::AllFalse(d, meets)) met[place].add(numbers, enter, meets);
      }
    }
    for (int place = 0; place < order.count; ++place) met[place].pad();
  }

  const Traversed<measure, any, radii>& traversed_;
  const QuerySetup& setup_;
  RayBatch batch_{};
  unsigned octant_ = 0;
  std::uint64_t answers_ = 0;  ///< grows when rays may have found better points
  std::vector<Lists> lists_;   ///< by depth
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
