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

  /// The first `count` points of a leaf below a frame of this level. For `any`, state.found tells whether to
  /// go on.
  void visit(RayState& state, const Leaf& leaf, std::uint32_t count, int level) const {
    // Around the foot of the perpendicular from the frame's corner numbers are small, and so are errors.
    double from_corner[3], foot[3];
    for (int axis = 0; axis < 3; ++axis)
      from_corner[axis] = state.origin[axis] - setup_.tree.lattice.scale[axis] * leaf.corner[axis];
    const double foot_t = -(from_corner[0] * state.direction[0] + from_corner[1] * state.direction[1] +
                            from_corner[2] * state.direction[2]);
    for (int axis = 0; axis < 3; ++axis) foot[axis] = from_corner[axis] + foot_t * state.direction[axis];

    const int shift = coordinate_shift(level);
    const double lost = shift > 0 ? 2.0 * setup_.widest_scale * power_of_two(shift) : 0.0;
    const double error = state.double_error + lost +
                         0x1p-18 * (setup_.widest_scale * power_of_two(level) + setup_.query.radius);
    const double outer = setup_.query.radius + error;
    const double inner = setup_.query.radius - error;

    const PointLanes d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    // For the half chord h = sqrt(r^2 - distance^2) of the sphere:
    // (r + e)^2 - (x + e)^2 >= r^2 - x^2 >= (r - e)^2 - (x - e)^2 for e <= x + e <= r.
    const auto outer_sq = hn::Set(d, float_above(outer * outer));
    const auto inner_sq = hn::Set(d, inner > 0.0 && !all_in_double_ ? float_below(inner * inner) : -1.0f);
    const auto low = hn::Set(d, float_below(state.t_min - foot_t - error));
    // What begins after the cut does not count; a sphere begins at most its radius before its t.
    double latest = state.cut - foot_t + error;
    if (measure == Measure::entry) latest = std::min(latest + outer, state.t_max - foot_t + error);
    const auto high = hn::Set(d, float_above(latest));
    const auto float_error = hn::Set(d, float_above(error));

    const auto direction_x = hn::Set(d, static_cast<float>(state.direction[0])),
               direction_y = hn::Set(d, static_cast<float>(state.direction[1])),
               direction_z = hn::Set(d, static_cast<float>(state.direction[2]));
    const auto foot_x = hn::Set(d, static_cast<float>(foot[0])),
               foot_y = hn::Set(d, static_cast<float>(foot[1])),
               foot_z = hn::Set(d, static_cast<float>(foot[2]));
    const auto step = static_cast<float>(power_of_two(shift));
    const auto scale_x = hn::Set(d, setup_.float_scale[0] * step),
               scale_y = hn::Set(d, setup_.float_scale[1] * step),
               scale_z = hn::Set(d, setup_.float_scale[2] * step);

    alignas(64) float lows[k_max_leaf_size], highs[k_max_leaf_size];
    std::uint32_t possible = 0, certain = 0;

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
      unsigned bits = mask_bits(d, near);
      if (end - first < lanes) bits &= (1u << (end - first)) - 1u;
      if (bits == 0) continue;

      const auto counts = hn::And(hn::Le(distance_sq, inner_sq),
                                  hn::And(hn::Ge(t, hn::Set(d, float_above(state.t_min - foot_t + error))),
                                          hn::Le(t, hn::Set(d, float_below(state.t_max - foot_t - error)))));
      const auto zero = hn::Zero(d);
      const auto entry_low =
          hn::Sub(hn::Sub(t, float_error), hn::Sqrt(hn::Max(hn::Sub(outer_sq, distance_sq), zero)));
      const auto entry_high =
          hn::Sub(hn::Add(t, float_error), hn::Sqrt(hn::Max(hn::Sub(inner_sq, distance_sq), zero)));
      const auto lies_after = hn::Ge(entry_low, hn::Set(d, float_above(state.entry_min - foot_t + error)));
      const auto measure_low = measure == Measure::entry ? entry_low : hn::Sub(t, float_error);
      const auto measure_high = measure == Measure::entry ? entry_high : hn::Add(t, float_error);
      unsigned sure = mask_bits(d, hn::And(counts, lies_after)) & bits;
      hn::Store(measure_low, d, lows + first);
      hn::Store(measure_high, d, highs + first);
      possible |= bits << first;
      certain |= sure << first;
    }
    if (possible != 0) choose(state, leaf, foot_t, lows, highs, possible, certain);
  }

  /// Every point of a leaf, decided in double only.
  void visit_in_double(RayState& state, const Leaf& leaf) const {
    for (std::uint32_t i = 0; i < leaf.count && !(any && state.found); ++i) decide(state, {leaf, i});
  }

  /// The ray's best point as a hit.
  std::optional<Hit> answer(const RayState& state) const {
    if (!state.found) return std::nullopt;
    return in_double(state, state.best);
  }

 private:
  void choose(RayState& state, const Leaf& leaf, double foot_t, const float* lows, const float* highs,
              std::uint32_t possible, std::uint32_t certain) const {
    if constexpr (any) {
      if (certain != 0) {
        finish(state);
        return;
      }
      for (; possible != 0 && !state.found; possible &= possible - 1)
        if (in_double(state, {leaf, index_of_lowest(possible)})) finish(state);
      return;
    }
    // The certain point that surely begins first cuts off most others before anything is decided.
    std::uint32_t leader = k_max_leaf_size;
    double leader_high = state.cut - foot_t;
    for (std::uint32_t rest = certain; rest != 0; rest &= rest - 1) {
      const std::uint32_t i = index_of_lowest(rest);
      if (highs[i] < leader_high) {
        leader_high = highs[i];
        leader = i;
      }
    }
    if (leader < k_max_leaf_size) {
      if (foot_t + highs[leader] < state.best_low) {
        take(state, {leaf, leader}, foot_t + lows[leader], foot_t + highs[leader]);
        possible &= ~(1u << leader);
      }
    }
    for (; possible != 0; possible &= possible - 1) {
      const std::uint32_t i = index_of_lowest(possible);
      if (foot_t + lows[i] <= state.cut) decide(state, {leaf, i});
    }
  }

  /// Any point is enough: nothing more counts.
  static void finish(RayState& state) {
    state.found = true;
    state.t_cut = -std::numeric_limits<float>::infinity();
  }

  static std::uint32_t index_of_lowest(std::uint32_t bits) {
    return static_cast<std::uint32_t>(std::countr_zero(bits));
  }

  static void take(RayState& state, const Best& point, double low, double high) {
    state.found = true;
    state.best = point;
    state.best_low = low;
    state.cut_at(std::min(high, state.cut));
  }

  void decide(RayState& state, const Best& point) const {
    const std::optional<Hit> hit = in_double(state, point);
    if (!hit) return;
    if (state.found) {
      const std::optional<Hit> best = in_double(state, state.best);
      if (!precedes(measure, *hit, *best)) {
        settle(state, *best);
        return;
      }
    }
    state.found = true;
    state.best = point;
    settle(state, *hit);
  }

  /// The best point's measure is known to the last bit.
  static void settle(RayState& state, const Hit& best) {
    const double local = measured(measure, best) - state.shift;
    state.best_low = local - state.double_error;
    state.cut_at(std::min(local + state.double_error, state.cut));
  }

  std::optional<Hit> in_double(const RayState& state, const Best& point) const {
    return evaluate(rays_[state.number], setup_.query,
                    to_world(setup_.tree.lattice, position_of(setup_.tree, point.leaf, point.index)),
                    point_id(setup_.tree, point.leaf.place + point.index), first_index_ + state.number);
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
