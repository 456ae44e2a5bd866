// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_LEAF_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_LEAF_TEST_INL_H
#undef ALIDADE_SIMD_LEAF_TEST_INL_H
#else
#define ALIDADE_SIMD_LEAF_TEST_INL_H
#endif

#include <bit>
#include <optional>
#include <span>

#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Tests the points of leaves against rays and keeps the best.
///
/// Lanes compute t and distance of every point within `error` of the truth. That tells for nearly all points
/// whether they can count (most cannot) or certainly do, and bounds of their measure. Only where bounds
/// overlap, or the edge of a condition is nearer than `error`, is a point decided in double
/// (octree/candidate.h). So the answer is the same bits on every machine, at the price of floats.
template <Measure measure, bool any>
class LeafTest {
 public:
  /// first_index: query_index of rays[0].
  LeafTest(const QuerySetup& setup, std::span<const Ray> rays, std::size_t first_index)
      : setup_(setup),
        rays_(rays),
        first_index_(first_index),
        all_in_double_(static_cast<bool>(setup.query.filter)) {}

  /// Leaves below one frame.
  struct Place {
    alignas(32) double corner[4];  ///< of the frame, from the root's, in metres
    double error;
    float outer_sq, inner_sq;
    float scale[3];

    Place(const QuerySetup& setup, const std::uint32_t* frame_corner, int level, bool all_in_double) {
      error = setup.leaf_error(level);
      for (int axis = 0; axis < 3; ++axis) corner[axis] = setup.scale[axis] * frame_corner[axis];
      corner[3] = 0.0;
      const double outer = setup.query.radius + error, inner = setup.query.radius - error;
      // For the half chord h = sqrt(r^2 - distance^2) of the sphere:
      // (r + e)^2 - (x + e)^2 >= r^2 - x^2 >= (r - e)^2 - (x - e)^2 for e <= x + e <= r.
      outer_sq = float_above(outer * outer);
      inner_sq = inner > 0.0 && !all_in_double ? float_below(inner * inner) : -1.0f;
      const auto step = static_cast<float>(power_of_two(coordinate_shift(level)));
      for (int axis = 0; axis < 3; ++axis) scale[axis] = setup.float_scale[axis] * step;
    }
  };

  Place place(const std::uint32_t* frame_corner, int level) const {
    return {setup_, frame_corner, level, all_in_double_};
  }

  /// The first `count` points of a leaf. For `any`, state.found tells whether to go on.
  void visit(RayBoxes& boxes, RayState& state, const Leaf& leaf, std::uint32_t count,
             const Place& place) const {
    // Around the foot of the perpendicular from the frame's corner numbers are small, and so are errors.
    alignas(32) double from_corner[4];
    alignas(16) float foot[4], direction[4];
    for (int axis = 0; axis < 4; ++axis) from_corner[axis] = state.origin[axis] - place.corner[axis];
    const double foot_t = -(from_corner[0] * state.direction[0] + from_corner[1] * state.direction[1] +
                            from_corner[2] * state.direction[2]);
    for (int axis = 0; axis < 4; ++axis) {
      foot[axis] = static_cast<float>(from_corner[axis] + foot_t * state.direction[axis]);
      direction[axis] = static_cast<float>(state.direction[axis]);
    }

    const PointLanes d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    const double error = place.error;
    const auto outer_sq = hn::Set(d, place.outer_sq), inner_sq = hn::Set(d, place.inner_sq);
    const auto low = hn::Set(d, float_below(state.t_min - foot_t - error));
    // What begins after the cut does not count; a sphere begins at most its radius before its t.
    double latest = state.cut - foot_t + error;
    if constexpr (measure == Measure::entry)
      latest = std::min(latest + (setup_.query.radius + error), state.t_max - foot_t + error);
    const auto high = hn::Set(d, float_above(latest));
    const auto direction_x = hn::Set(d, direction[0]), direction_y = hn::Set(d, direction[1]),
               direction_z = hn::Set(d, direction[2]);
    const auto foot_x = hn::Set(d, foot[0]), foot_y = hn::Set(d, foot[1]), foot_z = hn::Set(d, foot[2]);
    const auto scale_x = hn::Set(d, place.scale[0]), scale_y = hn::Set(d, place.scale[1]),
               scale_z = hn::Set(d, place.scale[2]);

    // All groups first, without asking in between: which of them hold a possible point nobody can foresee.
    alignas(64) float ts[k_max_leaf_size], distances_sq[k_max_leaf_size];
    std::uint32_t possible = 0;
    const std::uint16_t* coordinates = setup_.tree.coordinates + std::size_t{3} * leaf.place;
    const auto stride = static_cast<int>(leaf.count), end = static_cast<int>(count);
    for (int first = 0; first < end; first += lanes) {
      const auto x = hn::MulSub(load_as_float(d, coordinates + first), scale_x, foot_x),
                 y = hn::MulSub(load_as_float(d, coordinates + stride + first), scale_y, foot_y),
                 z = hn::MulSub(load_as_float(d, coordinates + 2 * stride + first), scale_z, foot_z);
      const auto t = hn::MulAdd(z, direction_z, hn::MulAdd(y, direction_y, hn::Mul(x, direction_x)));
      const auto across_x = hn::NegMulAdd(t, direction_x, x), across_y = hn::NegMulAdd(t, direction_y, y),
                 across_z = hn::NegMulAdd(t, direction_z, z);
      const auto distance_sq =
          hn::MulAdd(across_z, across_z, hn::MulAdd(across_y, across_y, hn::Mul(across_x, across_x)));
      const auto near = hn::And(hn::Le(distance_sq, outer_sq), hn::And(hn::Ge(t, low), hn::Le(t, high)));
      hn::Store(t, d, ts + first);
      hn::Store(distance_sq, d, distances_sq + first);
      possible |= mask_bits(d, near) << first;
    }
    possible &= 0xffffffffu >> (k_max_leaf_size - end);
    if (possible == 0) return;

    const auto float_error = hn::Set(d, float_above(error));
    const auto surely_low = hn::Set(d, float_above(state.t_min - foot_t + error)),
               surely_high = hn::Set(d, float_below(state.t_max - foot_t - error)),
               surely_after = hn::Set(d, float_above(state.entry_min - foot_t + error));
    const auto none = hn::Set(d, std::numeric_limits<float>::infinity());
    alignas(64) float lows[k_max_leaf_size], highs[k_max_leaf_size];
    auto first_high = none;
    for (int first = 0; first < end; first += lanes) {
      const auto t = hn::Load(d, ts + first), distance_sq = hn::Load(d, distances_sq + first);
      const auto zero = hn::Zero(d);
      const auto entry_low =
          hn::Sub(hn::Sub(t, float_error), hn::Sqrt(hn::Max(hn::Sub(outer_sq, distance_sq), zero)));
      const auto sure = hn::And(hn::And(hn::Le(distance_sq, inner_sq), hn::Ge(entry_low, surely_after)),
                                hn::And(hn::Ge(t, surely_low), hn::Le(t, surely_high)));
      auto measure_low = entry_low, measure_high = hn::Add(t, float_error);
      if constexpr (measure == Measure::entry) {
        measure_high = hn::Sub(measure_high, hn::Sqrt(hn::Max(hn::Sub(inner_sq, distance_sq), zero)));
      } else {
        measure_low = hn::Sub(t, float_error);
      }
      measure_high = hn::IfThenElse(sure, measure_high, none);
      if (end - first < lanes) measure_high = hn::IfThenElse(hn::FirstN(d, end - first), measure_high, none);
      first_high = hn::Min(first_high, measure_high);
      hn::Store(measure_low, d, lows + first);
      hn::Store(measure_high, d, highs + first);
    }
    first_high = hn::MinOfLanes(d, first_high);
    const float leader_high = hn::GetLane(first_high);
    if constexpr (any) {
      choose_any(boxes, state, leaf, possible, leader_high < std::numeric_limits<float>::infinity());
      return;
    }
    // The certain point that surely begins first cuts off most others before anything is decided.
    const auto cut = hn::Min(first_high, hn::Set(d, float_above(state.cut - foot_t)));
    std::uint32_t begins_before = 0, leaders = 0;
    for (int first = 0; first < end; first += lanes) {
      begins_before |= mask_bits(d, hn::Le(hn::Load(d, lows + first), cut)) << first;
      leaders |= mask_bits(d, hn::Eq(hn::Load(d, highs + first), first_high)) << first;
    }
    possible &= begins_before;
    if (possible == 0) return;
    if (foot_t + leader_high < state.best_low) {
      const std::uint32_t leader = index_of_lowest(leaders);
      take(boxes, state, leaf, leader, foot_t + lows[leader], foot_t + leader_high);
      possible &= ~(1u << leader);
    }
    for (; possible != 0; possible &= possible - 1) {
      const std::uint32_t i = index_of_lowest(possible);
      if (foot_t + lows[i] <= state.cut) decide(boxes, state, leaf, i);
    }
  }

  /// The ray's best point as a hit.
  std::optional<Hit> answer(const RayState& state) const {
    if (!state.found) return std::nullopt;
    return in_double(state, state.best_leaf, state.best_index);
  }

 private:
  void choose_any(RayBoxes& boxes, RayState& state, const Leaf& leaf, std::uint32_t possible,
                  bool certain) const {
    if (certain) {
      finish(boxes, state);
      return;
    }
    for (; possible != 0 && !state.found; possible &= possible - 1)
      if (in_double(state, leaf, index_of_lowest(possible))) finish(boxes, state);
  }

  /// Any point is enough: nothing more counts.
  static void finish(RayBoxes& boxes, RayState& state) {
    state.found = true;
    boxes.t_cut = -std::numeric_limits<float>::infinity();
  }

  static std::uint32_t index_of_lowest(std::uint32_t bits) {
    return static_cast<std::uint32_t>(std::countr_zero(bits));
  }

  static void take(RayBoxes& boxes, RayState& state, const Leaf& leaf, std::uint32_t index, double low,
                   double high) {
    state.found = true;
    state.best_leaf = leaf;
    state.best_index = index;
    state.best_low = low;
    cut_at(boxes, state, high);
  }

  static void cut_at(RayBoxes& boxes, RayState& state, double t) {
    if (t > state.cut) return;
    state.cut = t;
    boxes.t_cut = float_above(t);
  }

  void decide(RayBoxes& boxes, RayState& state, const Leaf& leaf, std::uint32_t index) const {
    const std::optional<Hit> hit = in_double(state, leaf, index);
    if (!hit) return;
    if (state.found) {
      const std::optional<Hit> best = in_double(state, state.best_leaf, state.best_index);
      // Coordinates of a damaged index file can lie where floats are sure of them and doubles are not.
      if (best && !precedes(measure, *hit, *best)) {
        settle(boxes, state, *best);
        return;
      }
    }
    state.found = true;
    state.best_leaf = leaf;
    state.best_index = index;
    settle(boxes, state, *hit);
  }

  /// The best point's measure is known to the last bit.
  void settle(RayBoxes& boxes, RayState& state, const Hit& best) const {
    const double local = measured(measure, best) - state.shift;
    state.best_low = local - setup_.double_error;
    cut_at(boxes, state, local + setup_.double_error);
  }

  std::optional<Hit> in_double(const RayState& state, const Leaf& leaf, std::uint32_t index) const {
    return evaluate(rays_[state.number], setup_.query,
                    to_world(setup_.tree.lattice, position_of(setup_.tree, leaf, index)),
                    point_id(setup_.tree, leaf.place + index), first_index_ + state.number);
  }

  const QuerySetup& setup_;
  const std::span<const Ray> rays_;
  const std::size_t first_index_;
  const bool all_in_double_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
