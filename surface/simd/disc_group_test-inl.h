// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_DISC_GROUP_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_DISC_GROUP_TEST_INL_H
#undef ALIDADE_SIMD_DISC_GROUP_TEST_INL_H
#else
#define ALIDADE_SIMD_DISC_GROUP_TEST_INL_H
#endif

#include "octree/simd/leaf_group_test-inl.h"
#include "surface/simd/own_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// LeafGroupTest for discs: one lane per ray, so that sheets are unpacked once for all rays. Discs of one
/// sheet overlap, and often several may be the first: those are decided in double here, as LeafTest does.
template <bool any>
class DiscGroupTest {
 public:
  using Single = LeafTest<Discs, any>;

  /// The first `count` points of a leaf.
  DiscGroupTest(const QuerySetup& setup, const Single& single, const Leaf& leaf, std::uint32_t count,
                const typename Single::LeafFrame& frame)
      : setup_(setup), single_(single), leaf_(leaf), count_(count), frame_(frame) {
    const PointLanes d;
    const std::uint16_t* coordinates = setup.tree.coordinates + std::size_t{3} * leaf.first;
    const auto error = hn::Set(d, float_above(frame.error));
    for (std::uint32_t i = 0; i < count; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
      for (int axis = 0; axis < 3; ++axis)
        hn::Store(
            hn::Mul(load_as_float(d, coordinates + axis * leaf.count + i), hn::Set(d, frame.scale[axis])), d,
            points_[axis] + i);
      const auto radius = single.points().radii(d, leaf.first + i);
      hn::Store(radius, d, radius_ + i);
      hn::Store(SquaredRadius::outer(d, radius, error), d, outer_sq_ + i);
      hn::Store(SquaredRadius::inner(d, radius, error), d, inner_sq_ + i);
    }
  }

  /// Batch: RayBatch or PacketBatch.
  template <class Batch>
  void visit(const Batch& batch, const RayList& list, std::uint64_t& tests) {
    for (std::uint32_t i = 0; i < list.count; i += static_cast<std::uint32_t>(hn::Lanes(RayLanes())))
      visit_group(batch, list.rays + i, list.t_near + i, list.count - i, tests);
  }

 private:
  static constexpr std::size_t k_most_lanes = RaysInLeaf::k_most_lanes;

  template <class Batch>
  void visit_group(const Batch& batch, const std::uint32_t* rays, const float* t_near, std::uint32_t left,
                   std::uint64_t& tests) {
    const RayLanes d;
    const std::size_t rows = std::min<std::size_t>(hn::Lanes(d), left);
    const RaysInLeaf group(batch, rays, t_near, rows, frame_.corner);
    const auto error = hn::Set(d, float_above(frame_.error));
    const auto reach = hn::Add(hn::Set(d, single_.radius_above()), error);
    const auto low = hn::Sub(hn::Sub(group.t_min, error), reach),
               high = hn::Add(hn::Add(group.cut, error), reach);
    const auto in_list = lanes_in_list(0, left);

    alignas(64) float ts[k_max_leaf_size][k_most_lanes], distances_sq[k_max_leaf_size][k_most_lanes];
    const auto from_start = [&](std::uint32_t i, int axis) {
      return hn::Sub(hn::Set(d, points_[axis][i]), axis == 0 ? group.x : axis == 1 ? group.y : group.z);
    };
    const auto is_near = [&](std::uint32_t i, RayVector t, RayVector distance_sq) {
      return hn::And(hn::Le(distance_sq, hn::Set(d, outer_sq_[i])), hn::And(hn::Ge(t, low), hn::Le(t, high)));
    };
    std::uint32_t possible = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      const auto [t, distance_sq] = on_line(from_start(i, 0), from_start(i, 1), from_start(i, 2),
                                            group.direction_x, group.direction_y, group.direction_z);
      hn::Store(t, d, ts[i]);
      hn::Store(distance_sq, d, distances_sq[i]);
      possible |= (hn::AllFalse(d, is_near(i, t, distance_sq)) ? 0u : 1u) << i;
    }
    if (possible == 0) return;
    load_sheets();
    const RaysAtDiscs at_discs = rays_at_discs(batch, rays, t_near, rows, group);

    const auto none = hn::Set(d, std::numeric_limits<float>::infinity());
    const auto before = hn::Add(group.cut, error), after = hn::Sub(group.t_min, error);
    const auto surely_low = hn::Add(group.t_min, error), surely_high = hn::Sub(group.t_max, error),
               surely_after = hn::Add(group.entry_min, error);
    const hn::RebindToUnsigned<RayLanes> n;
    auto leader_low = none, leader_high = none;
    auto leader = hn::Zero(n);
    // Lows replace distances that have been read.
    auto& lows = distances_sq;
    for (std::uint32_t rest = possible; rest != 0; rest &= rest - 1) {
      const std::uint32_t i = index_of_lowest_bit(rest);
      const auto t = hn::Load(d, ts[i]), distance_sq = hn::Load(d, distances_sq[i]);
      const NearRay near{
          from_start(i, 0),         from_start(i, 1),         from_start(i, 2),      t, distance_sq, error,
          hn::Set(d, outer_sq_[i]), hn::Set(d, inner_sq_[i]), hn::Set(d, radius_[i])};
      const bool is_disc = (exists_ >> i & 1u) != 0, is_amid = (amid_ >> i & 1u) != 0;
      const Crossings met =
          is_disc ? single_.points().test().of_discs(
                        {hn::Set(d, planes_[0][i]), hn::Set(d, planes_[1][i]), hn::Set(d, planes_[2][i]),
                         hn::Set(d, planes_[3][i]), hn::Set(d, planes_[4][i])},
                        hn::FirstN(d, is_amid ? hn::Lanes(d) : 0), near, at_discs)
                  : single_.points().test().of_spheres(near);
      const auto counts = hn::And(hn::And(is_near(i, t, distance_sq), hn::Le(met.low, met.high)),
                                  hn::And(hn::Le(met.low, before), hn::Ge(met.high, after)));
      hn::Store(hn::IfThenElse(counts, met.low, none), d, lows[i]);
      const auto entry_low =
          hn::Sub(hn::Sub(t, error), hn::Sqrt(hn::Max(hn::Sub(near.outer_sq, distance_sq), hn::Zero(d))));
      const auto sure = hn::And(hn::And(hn::And(counts, met.sure), hn::Ge(entry_low, surely_after)),
                                hn::And(hn::Ge(met.low, surely_low), hn::Le(met.high, surely_high)));
      const auto leads = hn::And(sure, hn::Lt(met.high, leader_high));
      leader_high = hn::IfThenElse(leads, met.high, leader_high);
      leader_low = hn::IfThenElse(leads, met.low, leader_low);
      leader = hn::IfThenElse(hn::RebindMask(n, leads), hn::Set(n, i), leader);
    }
    // The certain point that surely begins first cuts off most others before anything is decided.
    const auto cut = hn::Min(leader_high, before);
    auto candidates = hn::Zero(n);
    for (std::uint32_t rest = possible; rest != 0; rest &= rest - 1) {
      const std::uint32_t i = index_of_lowest_bit(rest);
      const auto may_lead = hn::Le(hn::Load(d, lows[i]), cut);
      candidates = hn::Or(candidates, hn::IfThenElseZero(hn::RebindMask(n, may_lead), hn::Set(n, 1u << i)));
    }
    const auto is_met = hn::And(in_list, hn::RebindMask(d, hn::Ne(candidates, hn::Zero(n))));
    if (hn::AllFalse(d, is_met)) return;
    ++tests;
    alignas(64) float leader_lows[k_most_lanes], leader_highs[k_most_lanes];
    alignas(64) std::uint32_t leaders[k_most_lanes], all_candidates[k_most_lanes];
    hn::Store(leader_low, d, leader_lows);
    hn::Store(leader_high, d, leader_highs);
    hn::Store(leader, n, leaders);
    hn::Store(candidates, n, all_candidates);
    for_each_lane(is_met, [&](std::size_t lane) {
      const ActiveRay ray = batch[rays[lane]];
      const double start = t_near[lane];
      std::uint32_t undecided = all_candidates[lane];
      if (leader_highs[lane] < std::numeric_limits<float>::infinity()) {
        if constexpr (any) {
          single_.finish(ray, leaf_, leaders[lane]);
          return;
        }
        if (start + leader_highs[lane] < ray.state.best_low) {
          single_.take(ray, leaf_, leaders[lane], start + leader_lows[lane], start + leader_highs[lane]);
          undecided &= ~(1u << leaders[lane]);
        }
      }
      single_.decide_in_order(ray, leaf_, undecided, start, [&](std::uint32_t i) { return lows[i][lane]; });
    });
  }

  /// Unpacks the sheets of the leaf's points.
  void load_sheets() {
    if (has_sheets_) return;
    has_sheets_ = true;
    single_.points().touch(leaf_);
    const PointLanes d;
    for (std::uint32_t i = 0; i < count_; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
      const auto [planes, exists, is_amid] = single_.points().test().sheets(leaf_.first + i, count_ - i);
      hn::Store(planes.x, d, planes_[0] + i);
      hn::Store(planes.y, d, planes_[1] + i);
      hn::Store(planes.z, d, planes_[2] + i);
      hn::Store(planes.length, d, planes_[3] + i);
      hn::Store(planes.height, d, planes_[4] + i);
      exists_ |= mask_bits(d, exists) << i;
      amid_ |= mask_bits(d, is_amid) << i;
    }
  }

  template <class Batch>
  RaysAtDiscs rays_at_discs(const Batch& batch, const std::uint32_t* rays, const float* t_near,
                            std::size_t rows, const RaysInLeaf& group) const {
    RaysAtDiscs at_discs;
    at_discs.along[0] = group.direction_x;
    at_discs.along[1] = group.direction_y;
    at_discs.along[2] = group.direction_z;
    const SurfaceQuery& query = single_.points().query();
    if (query.discs->begins.empty()) return at_discs;
    alignas(64) float columns[7][k_most_lanes] = {};
    for (std::size_t row = 0; row < rows; ++row) {
      const LeftSheet left(batch[rays[row]], query, t_near[row], frame_.error);
      if (!left.is_near) continue;
      at_discs.leave_near_sheets = true;
      columns[0][row] = 1.0f;
      for (int axis = 0; axis < 3; ++axis) columns[1 + axis][row] = left.normal[axis];
      columns[4][row] = left.reach;
      columns[5][row] = left.thickness;
      columns[6][row] = left.way;
    }
    if (!at_discs.leave_near_sheets) return at_discs;
    const RayLanes d;
    at_discs.is_near = hn::Gt(hn::Load(d, columns[0]), hn::Zero(d));
    for (int axis = 0; axis < 3; ++axis) at_discs.normal[axis] = hn::Load(d, columns[1 + axis]);
    at_discs.reach = hn::Load(d, columns[4]);
    at_discs.thickness = hn::Load(d, columns[5]);
    at_discs.way = hn::Load(d, columns[6]);
    return at_discs;
  }

  const QuerySetup& setup_;
  const Single& single_;
  const Leaf leaf_;
  const std::uint32_t count_;
  const typename Single::LeafFrame& frame_;
  alignas(64) float points_[3][k_max_leaf_size];
  alignas(64) float radius_[k_max_leaf_size], outer_sq_[k_max_leaf_size], inner_sq_[k_max_leaf_size];
  // Of the points' sheets, once a ray is near a point: SheetPlanes in its order, and bits.
  bool has_sheets_ = false;
  alignas(64) float planes_[5][k_max_leaf_size];
  std::uint32_t exists_ = 0, amid_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
