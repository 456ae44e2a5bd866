// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_LEAF_GROUP_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_LEAF_GROUP_TEST_INL_H
#undef ALIDADE_SIMD_LEAF_GROUP_TEST_INL_H
#else
#define ALIDADE_SIMD_LEAF_GROUP_TEST_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "octree/simd/lanes-inl.h"
#include "octree/simd/leaf_test-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// One lane per ray.
using RayLanes = hn::CappedTag<float, 16>;
using RayNumbers = hn::RebindToUnsigned<RayLanes>;
using RayVector = hn::Vec<RayLanes>;

/// Elements behind the end of a list that vectors may overwrite.
constexpr std::uint32_t k_list_padding = 16;

/// Columns of a table with eight floats to the row, one lane per row.
struct EightColumns {
  RayVector column[8];
};

/// rows: whole vectors of numbers of rows, each within the table.
HWY_INLINE EightColumns load_columns(const float* table, const std::uint32_t* rows) {
  const RayLanes d;
  EightColumns loaded;
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX2
  const hn::RebindToUnsigned<hn::RepartitionToWide<RayLanes>> pairs;
  RayVector row[8];
  for (int i = 0; i < 8; ++i) {
    const hn::Full256<float> half;
#if HWY_TARGET == HWY_AVX3
    row[i] = hn::Combine(d, hn::LoadU(half, table + std::size_t{8} * rows[i + 8]),
                         hn::LoadU(half, table + std::size_t{8} * rows[i]));
#else
    row[i] = hn::LoadU(half, table + std::size_t{8} * rows[i]);
#endif
  }
  // Within blocks of four columns: rows by twos, then by fours.
  RayVector fours[2][4];
  for (int i = 0; i < 2; ++i) {
    const auto low_a = hn::BitCast(pairs, hn::InterleaveLower(d, row[4 * i], row[4 * i + 1]));
    const auto high_a = hn::BitCast(pairs, hn::InterleaveUpper(d, row[4 * i], row[4 * i + 1]));
    const auto low_b = hn::BitCast(pairs, hn::InterleaveLower(d, row[4 * i + 2], row[4 * i + 3]));
    const auto high_b = hn::BitCast(pairs, hn::InterleaveUpper(d, row[4 * i + 2], row[4 * i + 3]));
    fours[i][0] = hn::BitCast(d, hn::InterleaveLower(pairs, low_a, low_b));
    fours[i][1] = hn::BitCast(d, hn::InterleaveUpper(pairs, low_a, low_b));
    fours[i][2] = hn::BitCast(d, hn::InterleaveLower(pairs, high_a, high_b));
    fours[i][3] = hn::BitCast(d, hn::InterleaveUpper(pairs, high_a, high_b));
  }
  for (int i = 0; i < 4; ++i) {
    loaded.column[i] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(fours[1][i]), fours[0][i]);
    loaded.column[4 + i] = hn::OddEvenBlocks(fours[1][i], hn::SwapAdjacentBlocks(fours[0][i]));
  }
#else
  constexpr std::size_t k_most_lanes = 16;
  alignas(64) float columns[8][k_most_lanes];
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane)
    for (int i = 0; i < 8; ++i) columns[i][lane] = table[std::size_t{8} * rows[lane] + i];
  for (int i = 0; i < 8; ++i) loaded.column[i] = hn::Load(d, columns[i]);
#endif
  return loaded;
}

/// Lanes of a vector at `first` in a list of `count`.
HWY_INLINE hn::Mask<RayLanes> lanes_in_list(std::uint32_t first, std::uint32_t count) {
  return hn::FirstN(RayLanes(), count - first);
}

/// A vector of rays as boxes meet them; lanes from `count` on meet nothing.
struct RayGroup {
  RayVector inverse[3], origin_t[3], t_cut;

  RayGroup(const RayBoxes* boxes, const std::uint32_t* rays, std::uint32_t count) {
    static_assert(sizeof(RayBoxes) == 8 * sizeof(float));
    const EightColumns columns = load_columns(reinterpret_cast<const float*>(boxes), rays);
    for (int axis = 0; axis < 3; ++axis) {
      inverse[axis] = columns.column[axis];
      origin_t[axis] = columns.column[4 + axis];
    }
    t_cut = columns.column[7];
    const RayLanes d;
    if (count < hn::Lanes(d))
      t_cut =
          hn::IfThenElse(hn::FirstN(d, count), t_cut, hn::Set(d, -std::numeric_limits<float>::infinity()));
  }
};

/// Rays that meet the box of a node or leaf.
struct RayList {
  std::uint32_t* rays;  ///< numbers in the batch
  float* t_near;        ///< where they enter the box; null at the root
  std::uint32_t count;

  /// Appends lanes of a mask.
  HWY_INLINE void add(const hn::Vec<RayNumbers>& numbers, const RayVector& t,
                      const hn::Mask<RayLanes>& mask) {
    const RayLanes d;
    const RayNumbers n;
    // A whole vector at a time: what is past the count is written over or is padding.
    const Compressor compress(d, mask);
    hn::StoreU(compress(numbers), n, rays + count);
    hn::StoreU(compress(t), d, t_near + count);
    count += compress.count();
  }

  /// Discards the rays whose answers no point at t_near or beyond can change.
  void discard(const RayBoxes* boxes) {
    const RayLanes d;
    const RayNumbers n;
    const hn::RebindToSigned<RayLanes> indices;
    const auto* floats = reinterpret_cast<const float*>(boxes);
    const std::uint32_t before = count;
    count = 0;
    for (std::uint32_t i = 0; i < before; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
      const auto numbers = hn::LoadU(n, rays + i);
      const auto t = hn::LoadU(d, t_near + i);
      const auto cut = hn::GatherIndex(d, floats + 7, hn::BitCast(indices, hn::ShiftLeft<3>(numbers)));
      add(numbers, t, hn::And(hn::Le(t, cut), lanes_in_list(i, before)));
    }
    pad();
  }

  /// Repeats the first ray behind the end, for the last vector.
  void pad() {
    const RayLanes d;
    const RayNumbers n;
    if (count == 0) return;
    hn::StoreU(hn::Set(n, rays[0]), n, rays + count);
    if (t_near) hn::StoreU(hn::Set(d, t_near[0]), d, t_near + count);
  }
};

/// Rays from where they enter the leaf's box, relative to the frame's corner.
struct RaysInLeaf {
  RayVector x, y, z, direction_x, direction_y, direction_z;
  RayVector t_min, t_max, entry_min, cut;

  static constexpr std::size_t k_most_lanes = 16;

  template <class Batch>
  RaysInLeaf(const Batch& batch, const std::uint32_t* rays, const float* t_near, std::size_t rows,
             const double* corner) {
    alignas(64) float from[k_most_lanes][4], direction[k_most_lanes][4], limits[k_most_lanes][4];
    relative_to(batch[rays[0]], t_near[0], corner, from[0], direction[0], limits[0]);
    for (std::size_t row = 1; row < rows; ++row)
      relative_to(batch[rays[row]], t_near[row], corner, from[row], direction[row], limits[row]);
    // Lanes without a ray repeat the first one.
    for (std::size_t row = rows; row < hn::Lanes(RayLanes()); ++row) {
      std::copy_n(from[0], 4, from[row]);
      std::copy_n(direction[0], 4, direction[row]);
      std::copy_n(limits[0], 4, limits[row]);
    }
    const RayLanes d;
    RayVector padding;
    hn::LoadInterleaved4(d, from[0], x, y, z, padding);
    hn::LoadInterleaved4(d, direction[0], direction_x, direction_y, direction_z, padding);
    hn::LoadInterleaved4(d, limits[0], t_min, t_max, entry_min, cut);
  }
};

/// Calls visit(lane) for the lanes of a mask.
template <class Visit>
HWY_INLINE void for_each_lane(const hn::Mask<RayLanes>& mask, const Visit& visit) {
  for (unsigned bits = mask_bits(RayLanes(), mask); bits != 0; bits &= bits - 1)
    visit(static_cast<std::size_t>(std::countr_zero(bits)));
}

/// Tests the points of one leaf against a list of rays, one lane per ray. Lanes decide as those of LeafTest
/// do; where one point does not stand out, the ray goes to LeafTest.
template <class Points, bool any>
class LeafGroupTest {
 public:
  using Single = LeafTest<Points, any>;

  /// The first `count` points of a leaf.
  LeafGroupTest(const QuerySetup& setup, const Single& single, const Leaf& leaf, std::uint32_t count,
                const typename Single::LeafFrame& frame)
      : single_(single), leaf_(leaf), count_(count), frame_(frame) {
    const PointLanes d;
    const std::uint16_t* coordinates = setup.tree.coordinates + std::size_t{3} * leaf.first;
    for (int axis = 0; axis < 3; ++axis)
      for (std::uint32_t i = 0; i < count; i += static_cast<std::uint32_t>(hn::Lanes(d)))
        hn::Store(
            hn::Mul(load_as_float(d, coordinates + axis * leaf.count + i), hn::Set(d, frame.scale[axis])), d,
            points_[axis] + i);
    if constexpr (Points::own_radii) {
      const auto error = hn::Set(d, float_above(frame.error));
      for (std::uint32_t i = 0; i < count; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
        const auto radius = single.points().radii(d, leaf.first + i);
        hn::Store(SquaredRadius::outer(d, radius, error), d, outer_sq_ + i);
        hn::Store(SquaredRadius::inner(d, radius, error), d, inner_sq_ + i);
      }
    }
  }

  void visit(const RayBatch& batch, const RayList& list, std::uint64_t& tests) const {
    for (std::uint32_t i = 0; i < list.count; i += static_cast<std::uint32_t>(hn::Lanes(RayLanes())))
      visit_group(batch, list.rays + i, list.t_near + i, list.count - i, tests);
  }

 private:
  static constexpr std::size_t k_most_lanes = RaysInLeaf::k_most_lanes;
  static_assert(!Points::are_discs);

  void visit_group(const RayBatch& batch, const std::uint32_t* rays, const float* t_near, std::uint32_t left,
                   std::uint64_t& tests) const {
    const RayLanes d;
    const std::size_t rows = std::min<std::size_t>(hn::Lanes(d), left);
    const RaysInLeaf group(batch, rays, t_near, rows, frame_.corner);
    const auto error = hn::Set(d, float_above(frame_.error));
    const auto low = hn::Sub(group.t_min, error);
    auto high = hn::Add(group.cut, error);
    if constexpr (Points::measure == Measure::entry)
      high = hn::Min(hn::Add(high, hn::Add(error, hn::Set(d, single_.radius_above()))),
                     hn::Add(group.t_max, error));
    const auto in_list = lanes_in_list(0, left);
    const auto is_near = [&](std::uint32_t i, RayVector t, RayVector distance_sq) {
      return hn::And(hn::Le(distance_sq, outer_sq(i)), hn::And(hn::Ge(t, low), hn::Le(t, high)));
    };

    alignas(64) float ts[k_max_leaf_size][k_most_lanes], distances_sq[k_max_leaf_size][k_most_lanes];
    std::uint32_t possible = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      const auto x = hn::Sub(hn::Set(d, points_[0][i]), group.x),
                 y = hn::Sub(hn::Set(d, points_[1][i]), group.y),
                 z = hn::Sub(hn::Set(d, points_[2][i]), group.z);
      const auto [t, distance_sq] = on_line(x, y, z, group.direction_x, group.direction_y, group.direction_z);
      hn::Store(t, d, ts[i]);
      hn::Store(distance_sq, d, distances_sq[i]);
      possible |= (hn::AllFalse(d, is_near(i, t, distance_sq)) ? 0u : 1u) << i;
    }
    if (possible == 0) return;
    ++tests;

    const auto surely_low = hn::Add(group.t_min, error), surely_high = hn::Sub(group.t_max, error),
               surely_after = hn::Add(group.entry_min, error);
    if constexpr (any) {
      const auto surely_entered = hn::Add(surely_after, error);
      auto met = hn::FirstN(d, 0), found = met;
      for (; possible != 0; possible &= possible - 1) {
        const std::uint32_t i = index_of_lowest_bit(possible);
        const auto t = hn::Load(d, ts[i]), distance_sq = hn::Load(d, distances_sq[i]);
        const auto near = is_near(i, t, distance_sq);
        const auto is_inside =
            hn::And(hn::Le(distance_sq, inner_sq(i)),
                    enters_after(d, hn::Sub(t, surely_entered), hn::Sub(outer_sq(i), distance_sq)));
        met = hn::Or(met, near);
        found = hn::Or(
            found, hn::And(hn::And(near, is_inside), hn::And(hn::Ge(t, surely_low), hn::Le(t, surely_high))));
      }
      for_each_lane(hn::And(in_list, found),
                    [&](std::size_t lane) { single_.finish(batch[rays[lane]], leaf_, 0); });
      for_each_lane(hn::And(in_list, hn::AndNot(found, met)),
                    [&](std::size_t lane) { alone(batch[rays[lane]], t_near[lane]); });
      return;
    }
    const auto none = hn::Set(d, std::numeric_limits<float>::infinity());
    const auto zero = hn::Zero(d);
    // Of the certain points the one that surely begins first leads; of the lows of all possible ones the two
    // least show whether any other could begin before it ends.
    auto leader_low = none, leader_high = none, lowest = none, second_lowest = none;
    const hn::RebindToUnsigned<RayLanes> n;
    auto leader = hn::Zero(n);
    for (; possible != 0; possible &= possible - 1) {
      const std::uint32_t i = index_of_lowest_bit(possible);
      const auto t = hn::Load(d, ts[i]), distance_sq = hn::Load(d, distances_sq[i]);
      const auto outer_sq = this->outer_sq(i), inner_sq = this->inner_sq(i);
      const auto near = is_near(i, t, distance_sq);
      const auto entry_low =
          hn::Sub(hn::Sub(t, error), hn::Sqrt(hn::Max(hn::Sub(outer_sq, distance_sq), zero)));
      const auto sure =
          hn::And(hn::And(near, hn::And(hn::Le(distance_sq, inner_sq), hn::Ge(entry_low, surely_after))),
                  hn::And(hn::Ge(t, surely_low), hn::Le(t, surely_high)));
      auto measure_low = entry_low, measure_high = hn::Add(t, error);
      if constexpr (Points::measure == Measure::entry) {
        measure_high = hn::Sub(measure_high, hn::Sqrt(hn::Max(hn::Sub(inner_sq, distance_sq), zero)));
      } else {
        measure_low = hn::Sub(t, error);
      }
      measure_low = hn::IfThenElse(near, measure_low, none);
      second_lowest = hn::Min(second_lowest, hn::Max(lowest, measure_low));
      lowest = hn::Min(lowest, measure_low);
      const auto leads = hn::And(sure, hn::Lt(measure_high, leader_high));
      leader_high = hn::IfThenElse(leads, measure_high, leader_high);
      leader_low = hn::IfThenElse(leads, measure_low, leader_low);
      leader = hn::IfThenElse(hn::RebindMask(n, leads), hn::Set(n, i), leader);
    }
    const auto has_leader = hn::And(in_list, hn::Lt(leader_high, none));
    const auto cut = hn::Min(leader_high, hn::Add(group.cut, error));
    const auto counts = hn::And(in_list, hn::Le(lowest, cut));
    const auto stands_out =
        hn::And(hn::And(counts, has_leader), hn::And(hn::Eq(lowest, leader_low), hn::Gt(second_lowest, cut)));
    alignas(64) float leader_lows[k_most_lanes], leader_highs[k_most_lanes];
    alignas(64) std::uint32_t leaders[k_most_lanes];
    hn::Store(leader_low, d, leader_lows);
    hn::Store(leader_high, d, leader_highs);
    hn::Store(leader, n, leaders);
    for_each_lane(stands_out, [&](std::size_t lane) {
      const ActiveRay ray = batch[rays[lane]];
      const double t = t_near[lane];
      if (t + leader_highs[lane] < ray.state.best_low) {
        single_.take(ray, leaf_, leaders[lane], t + leader_lows[lane], t + leader_highs[lane]);
      } else {
        alone(batch[rays[lane]], t_near[lane]);
      }
    });
    for_each_lane(hn::AndNot(stands_out, counts),
                  [&](std::size_t lane) { alone(batch[rays[lane]], t_near[lane]); });
  }

  /// Squares of point i's radius: LeafTest::LeafFrame::outer_sq and LeafTest::inner_sq.
  HWY_INLINE RayVector outer_sq(std::uint32_t i) const {
    return hn::Set(RayLanes(), Points::own_radii ? outer_sq_[i] : frame_.outer_sq);
  }
  HWY_INLINE RayVector inner_sq(std::uint32_t i) const {
    return hn::Set(RayLanes(), Points::own_radii ? inner_sq_[i] : single_.inner_sq(frame_));
  }

  HWY_NOINLINE void alone(const ActiveRay& ray, float t_near) const {
    single_.visit(ray, leaf_, count_, frame_, t_near);
  }

  const Single& single_;
  const Leaf leaf_;
  const std::uint32_t count_;
  const typename Single::LeafFrame& frame_;
  alignas(64) float points_[3][k_max_leaf_size];
  alignas(64) float outer_sq_[k_max_leaf_size], inner_sq_[k_max_leaf_size];  ///< of own_radii
};

/// Tests the first `count` points of a leaf against the rays of a list, which is padded. `tests` changes when
/// rays may have found nearer points.
template <class Points, bool any, class Batch>
void test_leaf(const QuerySetup& setup, const LeafTest<Points, any>& single, const Leaf& leaf,
               std::uint32_t count, const typename LeafTest<Points, any>::LeafFrame& frame,
               const Batch& batch, const RayList& list, std::uint64_t& tests) {
  constexpr std::uint32_t k_min_rays = 3;  // fewer are tested one by one
  if (list.count >= k_min_rays && !single.all_in_double()) {
    typename Points::template GroupTest<any> group_test(setup, single, leaf, count, frame);
    group_test.visit(batch, list, tests);
    return;
  }
  for (std::uint32_t i = 0; i < list.count; ++i)
    single.visit(batch[list.rays[i]], leaf, count, frame, list.t_near[i]);
  ++tests;
}

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
