// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_LEAF_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_LEAF_TEST_INL_H
#undef ALIDADE_SIMD_LEAF_TEST_INL_H
#else
#define ALIDADE_SIMD_LEAF_TEST_INL_H
#endif

#include <optional>

#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// A ray from `start` (local t) on, relative to a frame's corner, in floats of four: position, direction,
/// RayLimits.
HWY_INLINE void relative_to(const ActiveRay& ray, double start, const double* corner, float* from,
                            float* along, float* limits) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<float, decltype(d)> floats;
  const auto local_t = hn::Set(d, start), t = hn::Set(d, start + ray.state.shift);
  for (std::size_t lane = 0; lane < 4; lane += hn::Lanes(d)) {
    // The fourth values are whatever is behind in memory; they are not used.
    const auto direction = hn::LoadU(d, &ray.input.direction.x + lane);
    const auto position = hn::MulAdd(t, direction, hn::LoadU(d, &ray.input.origin.x + lane));
    hn::StoreU(hn::DemoteTo(floats, hn::Sub(position, hn::LoadU(d, corner + lane))), floats, from + lane);
    hn::StoreU(hn::DemoteTo(floats, direction), floats, along + lane);
    hn::StoreU(hn::DemoteTo(floats, hn::Sub(hn::LoadU(d, &ray.state.limits.t_min + lane), local_t)), floats,
               limits + lane);
  }
}

/// Tests the points of leaves against rays and keeps the best. `Points` is their kind (shared_radius-inl.h).
///
/// Lanes compute t and distance of every point within `error` of the truth. That decides for nearly all
/// points whether they can count (most cannot) or certainly do, and bounds of their measure. Only where
/// bounds overlap, or the edge of a condition is nearer than `error`, is a point decided in double
/// (octree/candidate.h, surface/decide_point.h). So the answer is the same bits on every machine, at the price
/// of floats.
template <class Points, bool any>
class LeafTest {
 public:
  LeafTest(const QuerySetup& setup, const Points& points)
      : setup_(setup),
        points_(points),
        radius_above_(float_above(setup.query.radius)),
        all_in_double_(setup.query.filter) {}

  /// A frame, as the leaves below it need it.
  struct LeafFrame {
    double corner[4];  ///< of the frame, world
    double error;
    float outer_sq;
    float scale[3];

    LeafFrame(const QuerySetup& setup, const std::array<std::uint32_t, 3>& frame_corner, int level) {
      error = setup.leaf_error(level);
      for (int axis = 0; axis < 3; ++axis)
        corner[axis] = setup.tree.extent.corner[axis] + setup.tree.lattice.scale[axis] * frame_corner[axis];
      corner[3] = 0.0;
      const double outer = setup.query.radius + error;
      outer_sq = float_above(outer * outer);
      const auto step = static_cast<float>(power_of_two(coordinate_shift(level)));
      for (int axis = 0; axis < 3; ++axis) scale[axis] = setup.tree.extent.scale[axis] * step;
    }
  };

  LeafFrame leaf_frame(const std::array<std::uint32_t, 3>& frame_corner, int level) const {
    return {setup_, frame_corner, level};
  }

  /// A point certainly counts if its distance squared is not above. For the half chord
  /// h = sqrt(r^2 - distance^2) of the sphere: (r + e)^2 - (x + e)^2 >= r^2 - x^2 >= (r - e)^2 - (x - e)^2
  /// for e <= x + e <= r.
  float inner_sq(const LeafFrame& frame) const {
    const double inner = setup_.query.radius - frame.error;
    return inner > 0.0 && !all_in_double_ ? float_below(inner * inner) : -1.0f;
  }

  /// The first `count` points of a leaf, whose box the ray's line enters at t_near (local; rounding does not
  /// matter). For `any`, ray.state.found() ends the search.
  HWY_INLINE void visit(const ActiveRay& ray, const Leaf& leaf, std::uint32_t count, const LeafFrame& frame,
                        float t_near) const {
    constexpr std::uint32_t lanes = hn::MaxLanes(PointLanes());
    if (count <= lanes) {
      visit_vectors<1>(ray, leaf, count, frame, t_near);
    } else {
      visit_vectors<k_max_leaf_size / lanes>(ray, leaf, count, frame, t_near);
    }
  }

  /// Fetches what visit() reads of a leaf.
  HWY_INLINE void fetch(std::uint32_t first, std::uint32_t count) const {
    fetch_array(setup_.tree.coordinates + std::size_t{3} * first, std::size_t{3} * count);
    points_.fetch(first, count);
  }

  /// The ray's best point as a hit.
  std::optional<typename Points::Answer> answer(const ActiveRay& ray) const {
    if (!ray.state.found()) return std::nullopt;
    const std::optional<Hit> best = in_double(ray, ray.state.best_position, ray.state.best_index);
    if (!best) return std::nullopt;
    return Points::answer(*best, ray.state.best_index);
  }

  /// Whether the query rejects the first position of a leaf, whatever ids the points there have.
  bool rejects_first(const ActiveRay& ray, const Leaf& leaf) const {
    points_.touch(leaf);
    return !in_double(ray, position_of(setup_.tree, leaf, 0), leaf.first, Filters::of_position);
  }

  /// Makes a point of a leaf the best: its measure lies in [low, high], local t.
  void take(const ActiveRay& ray, const Leaf& leaf, std::uint32_t index, double low, double high) const {
    keep(ray, leaf, index);
    ray.state.best_low = low;
    cut_at(ray, high);
  }

  /// Any point is enough, and this one of a leaf counts: no other matters.
  void finish(const ActiveRay& ray, const Leaf& leaf, std::uint32_t index) const {
    // DiscPacketTest asks which one; of spheres no one does.
    if constexpr (Points::are_discs) {
      ray.state.best_position = position_of(setup_.tree, leaf, index);
      ray.state.best_index = leaf.first + index;
    }
    ray.state.best_low = -std::numeric_limits<double>::infinity();
    ray.boxes.t_cut = -std::numeric_limits<float>::infinity();
  }

  /// Decides those points of a leaf (bits) in double that can be the best. low_of(i): point i begins not
  /// before, from `start` on.
  template <class LowOf>
  void decide_in_order(const ActiveRay& ray, const Leaf& leaf, std::uint32_t possible, double start,
                       const LowOf& low_of) const {
    while (possible != 0) {
      std::uint32_t next = index_of_lowest_bit(possible);
      for (std::uint32_t rest = possible & (possible - 1); rest != 0; rest &= rest - 1) {
        const std::uint32_t i = index_of_lowest_bit(rest);
        if (low_of(i) < low_of(next)) next = i;
      }
      possible &= ~(1u << next);
      if constexpr (any) {
        if (!in_double(ray, leaf, next)) continue;
        finish(ray, leaf, next);
        return;
      }
      if (start + low_of(next) > ray.state.limits.cut) return;
      decide(ray, leaf, next);
    }
  }

  const Points& points() const { return points_; }
  bool all_in_double() const { return all_in_double_; }
  float radius_above() const { return radius_above_; }

 private:
  template <int vectors>
  HWY_NOINLINE void visit_vectors(const ActiveRay& ray, const Leaf& leaf, std::uint32_t count,
                                  const LeafFrame& frame, float t_near) const {
    // Around the point where the ray enters the leaf's box numbers are small, and so are errors.
    const auto start = static_cast<double>(t_near);
    alignas(16) float from[4], along[4], limits[4];
    relative_to(ray, start, frame.corner, from, along, limits);

    const PointLanes d;
    constexpr int lanes = hn::MaxLanes(PointLanes());
    const auto error = hn::Set(d, float_above(frame.error));
    hn::Vec<PointLanes> radius[vectors];
    if constexpr (Points::own_radii) {
      for (int i = 0; i < vectors; ++i) radius[i] = points_.radii(d, leaf.first + i * lanes);
    }
    const auto outer_sq_of = [&](int i) {
      if constexpr (Points::own_radii) return SquaredRadius::outer(d, radius[i], error);
      (void)i;
      return hn::Set(d, frame.outer_sq);
    };
    const auto inner_sq_of = [&](int i) {
      if constexpr (Points::own_radii) {
        if (!all_in_double_) return SquaredRadius::inner(d, radius[i], error);
        return hn::Set(d, -1.0f);
      }
      (void)i;
      return hn::Set(d, this->inner_sq(frame));
    };
    const auto t_min = hn::Set(d, limits[0]), t_max = hn::Set(d, limits[1]);
    auto low = hn::Sub(t_min, error);
    // What begins after the cut does not count; a sphere begins at most its radius before its t, and a disc
    // in it.
    auto high = hn::Add(hn::Set(d, limits[3]), error);
    const auto reach = hn::Add(hn::Set(d, radius_above_), error);
    if constexpr (Points::measure == Measure::entry)
      high = hn::Min(hn::Add(high, reach), hn::Add(t_max, error));
    if constexpr (Points::are_discs) {
      low = hn::Sub(low, reach);
      high = hn::Add(high, reach);
    }
    const auto along_x = hn::Set(d, along[0]), along_y = hn::Set(d, along[1]), along_z = hn::Set(d, along[2]);

    // All vectors first, without a branch in between: which hold a possible point cannot be predicted.
    hn::Vec<PointLanes> ts[vectors], distances_sq[vectors];
    std::uint32_t possible = 0;
    const std::uint16_t* coordinates = setup_.tree.coordinates + std::size_t{3} * leaf.first;
    const auto from_start = [&](int axis, int i) {
      return hn::MulSub(load_as_float(d, coordinates + axis * leaf.count + i * lanes),
                        hn::Set(d, frame.scale[axis]), hn::Set(d, from[axis]));
    };
    for (int i = 0; i < vectors; ++i) {
      const auto point =
          on_line(from_start(0, i), from_start(1, i), from_start(2, i), along_x, along_y, along_z);
      ts[i] = point.t;
      distances_sq[i] = point.distance_sq;
      const auto near =
          hn::And(hn::Le(distances_sq[i], outer_sq_of(i)), hn::And(hn::Ge(ts[i], low), hn::Le(ts[i], high)));
      possible |= mask_bits(d, near) << (i * lanes);
    }
    possible &= 0xffffffffu >> (k_max_leaf_size - count);
    if (possible == 0) return;
    const auto surely_low = hn::Add(t_min, error), surely_high = hn::Sub(t_max, error),
               surely_after = hn::Add(hn::Set(d, limits[2]), error);
    if constexpr (any && !Points::are_discs) {
      std::uint32_t sure = 0;
      const auto surely_entered = hn::Add(surely_after, error);
      for (int i = 0; i < vectors; ++i) {
        const auto is_inside = hn::And(
            hn::Le(distances_sq[i], inner_sq_of(i)),
            enters_after(d, hn::Sub(ts[i], surely_entered), hn::Sub(outer_sq_of(i), distances_sq[i])));
        const auto counts =
            hn::And(is_inside, hn::And(hn::Ge(ts[i], surely_low), hn::Le(ts[i], surely_high)));
        sure |= mask_bits(d, counts) << (i * lanes);
      }
      if ((sure & possible) != 0) return finish(ray, leaf, index_of_lowest_bit(sure & possible));
      for (; possible != 0 && !ray.state.found(); possible &= possible - 1) {
        const std::uint32_t i = index_of_lowest_bit(possible);
        if (in_double(ray, leaf, i)) finish(ray, leaf, i);
      }
      return;
    }
    const auto none = hn::Set(d, std::numeric_limits<float>::infinity());
    const auto zero = hn::Zero(d);
    hn::Vec<PointLanes> lows[vectors], highs[vectors];
    auto first_high = none;
    std::uint32_t crossed = 0;
    points_.touch(leaf);
    const auto ray_at_discs = points_.at_discs(ray, along, start, frame.error);
    for (int i = 0; i < vectors; ++i) {
      if constexpr (Points::are_discs) {
        if ((possible >> (i * lanes) & ((1ull << lanes) - 1u)) == 0) {
          lows[i] = highs[i] = none;
          continue;
        }
      }
      const auto outer_sq = outer_sq_of(i), inner_sq = inner_sq_of(i);
      const auto entry_low =
          hn::Sub(hn::Sub(ts[i], error), hn::Sqrt(hn::Max(hn::Sub(outer_sq, distances_sq[i]), zero)));
      auto sure = hn::And(hn::Le(distances_sq[i], inner_sq), hn::Ge(entry_low, surely_after));
      lows[i] = entry_low;
      highs[i] = hn::Add(ts[i], error);
      if constexpr (Points::are_discs) {
        const auto crossings = points_.crossings(leaf.first + i * lanes, count - i * lanes,
                                                 {from_start(0, i), from_start(1, i), from_start(2, i), ts[i],
                                                  distances_sq[i], error, outer_sq, inner_sq, radius[i]},
                                                 ray_at_discs);
        lows[i] = crossings.low;
        highs[i] = crossings.high;
        const auto counts =
            hn::And(hn::Le(lows[i], highs[i]), hn::And(hn::Le(lows[i], hn::Add(hn::Set(d, limits[3]), error)),
                                                       hn::Ge(highs[i], hn::Sub(t_min, error))));
        crossed |= mask_bits(d, counts) << (i * lanes);
        sure = hn::And(hn::And(sure, crossings.sure),
                       hn::And(hn::Ge(lows[i], surely_low), hn::Le(highs[i], surely_high)));
      } else {
        sure = hn::And(sure, hn::And(hn::Ge(ts[i], surely_low), hn::Le(ts[i], surely_high)));
      }
      if constexpr (Points::measure == Measure::entry) {
        highs[i] = hn::Sub(highs[i], hn::Sqrt(hn::Max(hn::Sub(inner_sq, distances_sq[i]), zero)));
      } else if constexpr (!Points::are_discs) {
        lows[i] = hn::Sub(ts[i], error);
      }
      const auto in_leaf = hn::FirstN(d, std::max(static_cast<int>(count) - i * lanes, 0));
      highs[i] = hn::IfThenElse(hn::And(sure, in_leaf), highs[i], none);
      first_high = hn::Min(first_high, highs[i]);
    }
    if constexpr (Points::are_discs) {
      possible &= crossed;
      if (possible == 0) return;
      if (setup_.tree.ids) hwy::Prefetch(setup_.tree.ids + leaf.first + index_of_lowest_bit(possible));
    }
    first_high = hn::MinOfLanes(d, first_high);
    // Highway's portable code for machines without vectors has no minimum above the largest finite float.
    first_high =
        hn::IfThenElse(hn::Lt(first_high, hn::Set(d, std::numeric_limits<float>::max())), first_high, none);
    const float leader_high = hn::GetLane(first_high);
    if constexpr (any) {
      if (leader_high < std::numeric_limits<float>::infinity()) {
        std::uint32_t leaders = 0;
        for (int i = 0; i < vectors; ++i)
          leaders |= mask_bits(d, hn::Eq(highs[i], first_high)) << (i * lanes);
        finish(ray, leaf, index_of_lowest_bit(leaders));
        return;
      }
    }
    // The certain point that surely begins first cuts off most others before anything is decided.
    const auto cut = hn::Min(first_high, hn::Add(hn::Set(d, limits[3]), error));
    std::uint32_t begins_before = 0, leaders = 0;
    alignas(64) float all_lows[k_max_leaf_size];
    for (int i = 0; i < vectors; ++i) {
      begins_before |= mask_bits(d, hn::Le(lows[i], cut)) << (i * lanes);
      leaders |= mask_bits(d, hn::Eq(highs[i], first_high)) << (i * lanes);
      hn::Store(lows[i], d, all_lows + i * lanes);
    }
    possible &= begins_before;
    if (possible == 0) return;
    if (start + leader_high < ray.state.best_low) {
      const std::uint32_t leader = index_of_lowest_bit(leaders);
      take(ray, leaf, leader, start + all_lows[leader], start + leader_high);
      possible &= ~(1u << leader);
    }
    if constexpr (Points::are_discs) {
      decide_in_order(ray, leaf, possible, start, [&](std::uint32_t i) { return all_lows[i]; });
      return;
    }
    for (; possible != 0; possible &= possible - 1) {
      const std::uint32_t i = index_of_lowest_bit(possible);
      if (start + all_lows[i] <= ray.state.limits.cut) decide(ray, leaf, i);
    }
  }

  static void cut_at(const ActiveRay& ray, double t) {
    if (t > ray.state.limits.cut) return;
    ray.state.limits.cut = t;
    ray.boxes.t_cut = float_above(t);
  }

  void decide(const ActiveRay& ray, const Leaf& leaf, std::uint32_t index) const {
    const std::optional<Hit> hit = in_double(ray, leaf, index);
    if (!hit) return;
    const bool is_surely_first = measured(Points::measure, *hit) - ray.state.shift < ray.state.best_low;
    if (!is_surely_first) {
      const std::optional<Hit> best = in_double(ray, ray.state.best_position, ray.state.best_index);
      // Coordinates of a damaged index file can lie where floats are sure of them and doubles are not.
      if (best && !precedes(Points::measure, *hit, *best)) {
        settle(ray, *best);
        return;
      }
    }
    keep(ray, leaf, index);
    settle(ray, *hit);
  }

  /// The best point's measure is known to the last bit.
  void settle(const ActiveRay& ray, const Hit& best) const {
    const double local = measured(Points::measure, best) - ray.state.shift;
    ray.state.best_low = local - setup_.double_error;
    cut_at(ray, local + setup_.double_error);
  }

  std::optional<Hit> in_double(const ActiveRay& ray, const Leaf& leaf, std::uint32_t index) const {
    return in_double(ray, position_of(setup_.tree, leaf, index), leaf.first + index);
  }

  std::optional<Hit> in_double(const ActiveRay& ray, const LatticePosition& position, std::uint32_t index,
                               Filters filters = Filters::all) const {
    return points_.evaluate(ray.input, index, to_world(setup_.tree.lattice, position), ray.query_index,
                            filters);
  }

  void keep(const ActiveRay& ray, const Leaf& leaf, std::uint32_t index) const {
    ray.state.best_position = position_of(setup_.tree, leaf, index);
    ray.state.best_index = leaf.first + index;
    // Read with the answer: few points that once were the best are not in the end.
    if (setup_.tree.ids) hwy::Prefetch(setup_.tree.ids + ray.state.best_index);
  }

  const QuerySetup& setup_;
  const Points& points_;
  const float radius_above_;
  const bool all_in_double_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
