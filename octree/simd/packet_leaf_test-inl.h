// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_PACKET_LEAF_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_PACKET_LEAF_TEST_INL_H
#undef ALIDADE_SIMD_PACKET_LEAF_TEST_INL_H
#else
#define ALIDADE_SIMD_PACKET_LEAF_TEST_INL_H
#endif

#include <vector>

#include "octree/simd/leaf_test-inl.h"
#include "octree/simd/packet_group-inl.h"
#include "octree/simd/recent_occluders-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Tests the points of leaves against the rays of a packet. Errors and the rules by which points are possible
/// or certain are those of LeafTest, but nothing is decided in double on the way: of each ray the certain
/// point that leads is kept with bounds of its measure, and the least lower bound of all other possible
/// points. At the end the leader is the answer unless another point may precede it: then the ray is traced
/// alone.
///
/// Bounds of a ray count from `base`, where it entered the last leaf, since differences of points of one leaf
/// or of neighbouring ones are small; they are widened by the rounding when the base moves.
template <class Points, bool any>
class PacketLeafTest {
 public:
  using Single = LeafTest<Points, any>;

  PacketLeafTest(const QuerySetup& setup, const Single& single, PacketRays& rays)
      : setup_(setup),
        single_(single),
        rays_(rays),
        widening_(Points::own_radii ? 0.0f : float_below(setup.query.radius)) {}

  /// For the rays that are loaded.
  void start(std::span<const Ray>, std::span<const std::uint32_t>, std::size_t) {
    const RayLanes d;
    const auto none = hn::Set(d, k_none);
    for (std::size_t lane = 0; lane < rays_.count; lane += hn::Lanes(d)) {
      hn::Store(hn::Zero(d), d, base_ + lane);
      hn::Store(none, d, low_ + lane);
      hn::Store(none, d, second_ + lane);
      hn::Store(none, d, high_ + lane);
    }
    found_ = unclear_ = 0;
    leaves_.clear();
  }

  /// The leaves that follow are below this frame.
  void enter(const Frame& frame) {
    frame_.emplace(setup_, frame.corner, frame.level);
    error_ = float_above(frame_->error);
    outer_sq_ = frame_->outer_sq;
    sure_above_ = sure_inside(outer_sq_, single_.inner_sq(*frame_));
  }

  /// The first `count` points of a leaf, for the rays that enter its box at t_near before their cuts, in
  /// these groups. far: the corner of the box, widened, that is the last one along the rays, from the setup's
  /// corner, mirrored; extent: no ray is inside the box for longer.
  void visit(const Leaf& leaf, std::uint32_t count, unsigned groups, const float* t_near,
             const float (&far)[3], float extent) {
    const RayLanes d;
    const auto is_any = [&](const hn::Mask<RayLanes>& mask) { return !hn::AllFalse(d, mask); };
    bool is_loaded = false;
    bool is_noted = false;
    for (; groups != 0; groups &= groups - 1) {
      const std::size_t first = static_cast<std::size_t>(std::countr_zero(groups)) * hn::Lanes(d);
      const auto t = hn::Load(d, t_near + first);
      auto meets = hn::Le(t, hn::Load(d, rays_.t_cut + first));
      const auto error = hn::Set(d, error_), low = hn::Load(d, rays_.limit_low + first);
      const auto begins_before = hn::Gt(hn::Add(low, error), t);
      const auto ends_behind =
          hn::Gt(hn::Add(t, hn::Set(d, extent + error_)), hn::Load(d, rays_.limit_high + first));
      const bool limited = is_any(hn::And(meets, hn::Or(begins_before, ends_behind)));
      // A sphere is not entered behind the projection of its centre. So what counts projects behind the
      // limits.
      if (limited)
        meets = hn::And(meets, hn::Ge(hn::Add(rays_.last_projection(first, far, widening_), error), low));
      const std::size_t rays = hn::CountTrue(d, meets);
      if (rays == 0) continue;
      if (!is_loaded) load(leaf, count);
      is_loaded = true;
      const PacketGroup group(rays_, frame_->corner, first, t, meets);
      if constexpr (any) {
        if (limited) {
          2 * rays <= count ? test_any_in_lanes<true>(group) : test_any<true>(group);
        } else {
          2 * rays <= count ? test_any_in_lanes<false>(group) : test_any<false>(group);
        }
      } else {
        Best best(*this, group);
        if (limited) {
          4 * rays <= count ? test_in_lanes<true>(group, best) : test<true>(group, best);
        } else {
          4 * rays <= count ? test_in_lanes<false>(group, best) : test<false>(group, best);
        }
        if (best.store(*this, group, static_cast<std::uint32_t>(leaves_.size()))) is_noted = true;
      }
    }
    if (is_noted) leaves_.push_back(leaf);
  }

  /// To be called when the rays are through the tree; then the results are there.
  void finish() {
    if constexpr (any) {
      unclear_ &= ~found_;
    } else {
      judge();
    }
  }

  /// Of this packet and of those before.
  const RecentOccluders& recent_occluders() const { return recent_; }
  /// Bit per ray: it has an answer.
  std::uint64_t found() const { return found_ & ~unclear_; }
  /// Bit per ray: it must be traced alone.
  std::uint64_t unclear() const { return unclear_ | rays_.far_away; }
  /// Of a ray that has an answer: where the point is.
  const Leaf& leaf_of(std::size_t lane) const { return leaves_[found_leaf_[lane]]; }
  std::uint32_t point_of(std::size_t lane) const { return found_point_[lane]; }

 private:
  static constexpr std::size_t k_size = PacketRays::k_size, k_most_lanes = PacketRays::k_most_lanes;
  /// Replaces infinity where sums must stay finite.
  static constexpr float k_none = 1e30f;
  using Numbers = hn::Vec<RayNumbers>;

  HWY_INLINE PointAtRay point_at(const PacketGroup& group, std::uint32_t i) const {
    const RayLanes d;
    const auto x = hn::Sub(hn::Set(d, points_[0][i]), group.from[0]),
               y = hn::Sub(hn::Set(d, points_[1][i]), group.from[1]),
               z = hn::Sub(hn::Set(d, points_[2][i]), group.from[2]);
    return point_at_ray(x, y, z, group.along[0], group.along[1], group.along[2], hn::Set(d, outer_sq(i)));
  }
  HWY_INLINE float outer_sq(std::uint32_t i) const { return Points::own_radii ? outer_sqs_[i] : outer_sq_; }
  /// A point whose PointAtRay::inside is at least this certainly is within its radius.
  HWY_INLINE float sure_above(std::uint32_t i) const {
    return Points::own_radii ? sure_aboves_[i] : sure_above_;
  }

  HWY_INLINE hn::Vec<PointLanes> sure_above_of(std::uint32_t first) const {
    return Points::own_radii ? hn::Load(PointLanes(), sure_aboves_ + first)
                             : hn::Set(PointLanes(), sure_above_);
  }

  void load(const Leaf& leaf, std::uint32_t count) {
    const PointLanes d;
    count_ = count;
    if constexpr (any) leaf_ = leaf;
    const std::uint16_t* coordinates = setup_.tree.coordinates + std::size_t{3} * leaf.first;
    for (int axis = 0; axis < 3; ++axis)
      for (std::uint32_t i = 0; i < count; i += static_cast<std::uint32_t>(hn::Lanes(d)))
        hn::Store(
            hn::Mul(load_as_float(d, coordinates + axis * leaf.count + i), hn::Set(d, frame_->scale[axis])),
            d, points_[axis] + i);
    if constexpr (Points::own_radii) {
      const auto error = hn::Set(d, error_);
      for (std::uint32_t i = 0; i < count; i += static_cast<std::uint32_t>(hn::Lanes(d))) {
        const auto radius = single_.points().radii(d, leaf.first + i);
        const auto outer = SquaredRadius::outer(d, radius, error),
                   inner = SquaredRadius::inner(d, radius, error);
        const auto rim =
            hn::MulAdd(outer, hn::Set(d, 0x1p-20f), hn::Mul(hn::Sub(outer, inner), hn::Set(d, k_up)));
        hn::Store(outer, d, outer_sqs_ + i);
        hn::Store(hn::IfThenElse(hn::Lt(inner, hn::Zero(d)),
                                 hn::Set(d, std::numeric_limits<float>::infinity()), rim),
                  d, sure_aboves_ + i);
      }
    }
  }

  /// The leader and the other points' least bound, from where the rays enter the leaf; measures without the
  /// error until they are stored.
  struct Best {
    RayVector low, second, high, root, rim;
    Numbers point;
    hn::Mask<RayLanes> is_new;

    HWY_INLINE Best(const PacketLeafTest& test, const PacketGroup& group) {
      const RayLanes d;
      const auto moved = hn::Sub(hn::Load(d, test.base_ + group.first), group.t_near);
      const auto old_high = hn::Load(d, test.high_ + group.first);
      const auto slack = hn::Mul(hn::Add(hn::Abs(moved), hn::Abs(old_high)), hn::Set(d, 0x1p-22f));
      const auto error = hn::Set(d, test.error_);
      const auto down = hn::Add(hn::Sub(moved, slack), error);
      low = hn::Add(hn::Load(d, test.low_ + group.first), down);
      second = hn::Add(hn::Load(d, test.second_ + group.first), down);
      high = hn::Add(hn::Add(old_high, moved), slack);
      root = hn::Set(d, 1.0f);
      rim = hn::Zero(d);
      point = hn::Zero(RayNumbers());
      is_new = hn::FirstN(d, 0);
    }

    /// Whether there is a new leader.
    HWY_INLINE bool store(PacketLeafTest& test, const PacketGroup& group, std::uint32_t leaf) {
      const RayLanes d;
      const RayNumbers n;
      const auto error = hn::Set(d, test.error_);
      const auto keep = [&](RayVector value, float* values) {
        hn::Store(hn::IfThenElse(group.meets, value, hn::Load(d, values + group.first)), d,
                  values + group.first);
      };
      keep(group.t_near, test.base_);
      keep(hn::Sub(low, error), test.low_);
      keep(hn::Sub(second, error), test.second_);
      const bool has_new = !hn::AllFalse(d, is_new);
      if (has_new) {
        // t + error - sqrt(chord - rim) <= t + error - root + rim / root.
        auto end = hn::Add(low, error);
        if constexpr (Points::measure == Measure::entry)
          end = hn::Add(end, hn::Mul(hn::Div(rim, root), hn::Set(d, k_up)));
        end = hn::MulAdd(hn::Abs(end), hn::Set(d, 0x1p-21f), end);
        high = hn::IfThenElse(is_new, end, high);
        const auto cut = hn::Add(group.t_near, high);
        const auto old_cut = hn::Load(d, test.rays_.t_cut + group.first);
        const auto new_cut = hn::Min(old_cut, hn::Add(hn::MulAdd(hn::Abs(cut), hn::Set(d, 0x1p-22f), cut),
                                                      hn::Set(d, std::numeric_limits<float>::min())));
        hn::Store(hn::IfThenElse(is_new, new_cut, old_cut), d, test.rays_.t_cut + group.first);
        const auto is_new_number = hn::RebindMask(n, is_new);
        hn::Store(hn::IfThenElse(is_new_number, point, hn::Load(n, test.found_point_ + group.first)), n,
                  test.found_point_ + group.first);
        hn::Store(
            hn::IfThenElse(is_new_number, hn::Set(n, leaf), hn::Load(n, test.found_leaf_ + group.first)), n,
            test.found_leaf_ + group.first);
      }
      keep(high, test.high_);
      return has_new;
    }
  };

  /// One lane per ray.
  template <bool limited>
  HWY_INLINE void test(const PacketGroup& group, Best& best) const {
    const RayLanes d;
    const RayNumbers n;
    const auto zero = hn::Zero(d), none = hn::Set(d, k_none);
    // All points first, without a branch in between: which of them are possible cannot be predicted.
    alignas(64) float ts[k_max_leaf_size][k_most_lanes], insides[k_max_leaf_size][k_most_lanes];
    std::uint32_t possible = 0;
    for (std::uint32_t i = 0; i < count_; ++i) {
      const auto [t, inside] = point_at(group, i);
      hn::Store(t, d, ts[i]);
      hn::Store(inside, d, insides[i]);
      possible |= (hn::AllFalse(d, hn::Ge(inside, zero)) ? 0u : 1u) << i;
    }
    if (possible == 0) return;
    std::optional<PacketLimits> limits;
    if constexpr (limited) limits.emplace(rays_, setup_.query, error_, group);
    for (; possible != 0; possible &= possible - 1) {
      const std::uint32_t i = index_of_lowest_bit(possible);
      const auto t = hn::Load(d, ts[i]), inside = hn::Load(d, insides[i]);
      const auto rim = hn::Set(d, sure_above(i));
      auto is_possible = hn::Ge(inside, zero), is_sure = hn::Ge(inside, rim);
      if constexpr (limited) {
        limits->apply(t, inside, rim, is_possible, is_sure);
        if (hn::AllFalse(d, is_possible)) continue;
      }
      auto low = t, root = zero;
      if constexpr (Points::measure == Measure::entry) {
        root = hn::Sqrt(hn::Max(inside, zero));
        low = hn::Sub(t, root);
      }
      low = hn::IfThenElse(is_possible, low, none);
      const auto leads = hn::And(is_sure, hn::Lt(low, best.low));
      best.second = hn::Min(best.second, hn::IfThenElse(leads, best.low, low));
      best.low = hn::IfThenElse(leads, low, best.low);
      best.root = hn::IfThenElse(leads, root, best.root);
      best.rim = hn::IfThenElse(leads, rim, best.rim);
      best.point = hn::IfThenElse(hn::RebindMask(n, leads), hn::Set(n, i), best.point);
      best.is_new = hn::Or(best.is_new, leads);
    }
  }

  /// Tests the points with one lane per point, for few rays.
  template <bool limited>
  HWY_NOINLINE void test_in_lanes(const PacketGroup& group, Best& best) const {
    std::optional<PacketLimitsByRay> limits;
    if constexpr (limited) limits.emplace(PacketLimits(rays_, setup_.query, error_, group));
    const RayLanes d;
    const RayNumbers n;
    alignas(64) float lows[k_most_lanes], seconds[k_most_lanes], roots[k_most_lanes], rims[k_most_lanes],
        is_new[k_most_lanes] = {};
    alignas(64) std::uint32_t points[k_most_lanes] = {};
    hn::Store(best.low, d, lows);
    hn::Store(best.second, d, seconds);
    hn::Store(best.root, d, roots);
    hn::Store(best.rim, d, rims);
    for_each_ray(group, [&](std::size_t lane, const OneRay& ray) {
      const PointLanes p;
      const auto none = hn::Set(p, k_none);
      for (std::uint32_t i = 0; i < count_; i += static_cast<std::uint32_t>(hn::Lanes(p))) {
        const auto [t, inside] = ray.point_at(*this, i);
        auto is_possible = hn::And(hn::Ge(inside, hn::Zero(p)), hn::FirstN(p, count_ - i));
        auto is_sure = hn::And(is_possible, hn::Ge(inside, sure_above_of(i)));
        if constexpr (limited) limits->of(lane).apply(t, inside, sure_above_of(i), is_possible, is_sure);
        if (hn::AllFalse(p, is_possible)) continue;
        auto low = t;
        if constexpr (Points::measure == Measure::entry)
          low = hn::Sub(t, hn::Sqrt(hn::Max(inside, hn::Zero(p))));
        is_possible = hn::And(is_possible, hn::Lt(low, hn::Set(p, seconds[lane])));
        if (hn::AllFalse(p, is_possible)) continue;
        low = hn::IfThenElse(is_possible, low, none);
        const auto least = hn::MinOfLanes(p, low);
        const unsigned first = mask_bits(p, hn::Eq(low, least));
        const std::uint32_t winner = i + static_cast<std::uint32_t>(std::countr_zero(first));
        const float least_low = hn::GetLane(least);
        alignas(64) float insides[k_most_lanes], all[k_most_lanes];
        hn::Store(inside, p, insides);
        hn::Store(low, p, all);
        all[winner - i] = k_none;
        const float next = hn::GetLane(hn::MinOfLanes(p, hn::Load(p, all)));
        if ((mask_bits(p, is_sure) >> (winner - i) & 1u) != 0 && least_low < lows[lane]) {
          seconds[lane] = std::min({seconds[lane], lows[lane], next});
          lows[lane] = least_low;
          roots[lane] = std::sqrt(insides[winner - i]);
          rims[lane] = sure_above(winner);
          points[lane] = winner;
          is_new[lane] = 1.0f;
        } else {
          seconds[lane] = std::min(seconds[lane], least_low);
        }
      }
    });
    best.low = hn::Load(d, lows);
    best.second = hn::Load(d, seconds);
    best.root = hn::Load(d, roots);
    best.rim = hn::Load(d, rims);
    best.point = hn::Load(n, points);
    best.is_new = hn::Gt(hn::Load(d, is_new), hn::Zero(d));
  }

  /// A ray for lanes of points.
  struct OneRay {
    float from[3], along[3];

    HWY_INLINE auto point_at(const PacketLeafTest& test, std::uint32_t i) const {
      const PointLanes d;
      const auto coordinate = [&](int axis) {
        return hn::Sub(hn::Load(d, test.points_[axis] + i), hn::Set(d, from[axis]));
      };
      const auto outer = Points::own_radii ? hn::Load(d, test.outer_sqs_ + i) : hn::Set(d, test.outer_sq_);
      return point_at_ray(coordinate(0), coordinate(1), coordinate(2), hn::Set(d, along[0]),
                          hn::Set(d, along[1]), hn::Set(d, along[2]), outer);
    }
  };
  template <class Use>
  HWY_INLINE void for_each_ray(const PacketGroup& group, const Use& use) const {
    const RayLanes d;
    alignas(64) float from[3][k_most_lanes];
    for (int axis = 0; axis < 3; ++axis) hn::Store(group.from[axis], d, from[axis]);
    for (unsigned rays = mask_bits(d, group.meets); rays != 0; rays &= rays - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rays));
      OneRay ray;
      for (int axis = 0; axis < 3; ++axis) {
        ray.from[axis] = from[axis][lane];
        ray.along[axis] = rays_.along[axis][group.first + lane];
      }
      use(lane, ray);
    }
  }

  /// Whether any point counts, one lane per ray.
  template <bool limited>
  HWY_INLINE void test_any(const PacketGroup& group) {
    const RayLanes d;
    const auto zero = hn::Zero(d);
    std::optional<PacketLimits> limits;
    if constexpr (limited) limits.emplace(rays_, setup_.query, error_, group);
    auto open = group.meets, is_unclear = hn::FirstN(d, 0);
    std::uint32_t last = count_;
    for (std::uint32_t i = 0; i < count_; ++i) {
      const auto [t, inside] = point_at(group, i);
      auto is_possible = hn::And(open, hn::Ge(inside, zero));
      if (hn::AllFalse(d, is_possible)) continue;
      const auto rim = hn::Set(d, sure_above(i));
      auto is_sure = hn::And(is_possible, hn::Ge(inside, rim));
      if constexpr (limited) limits->apply(t, inside, rim, is_possible, is_sure);
      is_unclear = hn::Or(is_unclear, hn::AndNot(is_sure, is_possible));
      if (hn::AllFalse(d, is_sure)) continue;
      last = i;
      open = hn::AndNot(is_sure, open);
      if (hn::AllFalse(d, open)) break;
    }
    if (last != count_) note_occluder(last);
    note_any(group.first, mask_bits(d, hn::AndNot(open, group.meets)), mask_bits(d, is_unclear));
  }

  template <bool limited>
  HWY_NOINLINE void test_any_in_lanes(const PacketGroup& group) {
    std::optional<PacketLimitsByRay> limits;
    if constexpr (limited) limits.emplace(PacketLimits(rays_, setup_.query, error_, group));
    unsigned found = 0, unclear = 0;
    for_each_ray(group, [&](std::size_t lane, const OneRay& ray) {
      const PointLanes p;
      for (std::uint32_t i = 0; i < count_; i += static_cast<std::uint32_t>(hn::Lanes(p))) {
        const auto [t, inside] = ray.point_at(*this, i);
        auto is_possible = hn::And(hn::FirstN(p, count_ - i), hn::Ge(inside, hn::Zero(p)));
        if (hn::AllFalse(p, is_possible)) continue;
        auto is_sure = hn::And(is_possible, hn::Ge(inside, sure_above_of(i)));
        if constexpr (limited) limits->of(lane).apply(t, inside, sure_above_of(i), is_possible, is_sure);
        if (!hn::AllFalse(p, is_sure)) {
          found |= 1u << lane;
          note_occluder(i + index_of_lowest_bit(mask_bits(p, is_sure)));
          return;
        }
        if (!hn::AllFalse(p, is_possible)) unclear |= 1u << lane;
      }
    });
    note_any(group.first, found, unclear);
  }

  void note_occluder(std::uint32_t point) {
    recent_.add(leaf_.first + point, position_of(setup_.tree, leaf_, point));
  }

  void note_any(std::size_t first, unsigned found, unsigned unclear) {
    found_ |= std::uint64_t{found} << first;
    unclear_ |= std::uint64_t{unclear} << first;
    for (; found != 0; found &= found - 1)
      rays_.t_cut[first + static_cast<std::size_t>(std::countr_zero(found))] =
          -std::numeric_limits<float>::infinity();
  }

  /// Which rays have a leader, and which have none or one that does not stand out.
  void judge() {
    const RayLanes d;
    const auto few = hn::Set(d, 0.5f * k_none);
    for (std::size_t lane = 0; lane < rays_.count; lane += hn::Lanes(d)) {
      const auto low = hn::Load(d, low_ + lane), second = hn::Load(d, second_ + lane),
                 high = hn::Load(d, high_ + lane);
      const auto found = hn::Lt(low, few);
      const auto unclear = hn::And(hn::Lt(second, few), hn::Or(hn::Not(found), hn::Le(second, high)));
      found_ |= std::uint64_t{mask_bits(d, found)} << lane;
      unclear_ |= std::uint64_t{mask_bits(d, unclear)} << lane;
    }
  }

  const QuerySetup& setup_;
  const Single& single_;
  PacketRays& rays_;
  const float widening_;  ///< of boxes, without what is for rounding
  // Of the frame that the leaves are below.
  std::optional<typename Single::LeafFrame> frame_;
  float error_ = 0.0f, outer_sq_ = 0.0f, sure_above_ = 0.0f;
  // Of the leaf.
  Leaf leaf_{};
  std::uint32_t count_ = 0;
  alignas(64) float points_[3][k_max_leaf_size];  ///< from the frame's corner, metres
  alignas(64) float outer_sqs_[k_max_leaf_size], sure_aboves_[k_max_leaf_size];  ///< of own_radii
  // Of the rays.
  alignas(64) float base_[k_size], low_[k_size], second_[k_size], high_[k_size];
  alignas(64) std::uint32_t found_leaf_[k_size], found_point_[k_size];
  std::uint64_t found_ = 0, unclear_ = 0;  ///< bit per ray
  std::vector<Leaf> leaves_;               ///< with points that once led
  RecentOccluders recent_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
