// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_PACKET_GROUP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_PACKET_GROUP_INL_H
#undef ALIDADE_SIMD_PACKET_GROUP_INL_H
#else
#define ALIDADE_SIMD_PACKET_GROUP_INL_H
#endif

#include <iterator>
#include <type_traits>

#include "octree/simd/packet_state-inl.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// f(first) gives doubles of half as many lanes as a vector of rays has, from lane `first` on; all of them as
/// floats.
template <class F>
HWY_INLINE RayVector from_doubles(const F& f) {
  const RayLanes d;
#if HWY_TARGET == HWY_SCALAR
  return hn::DemoteTo(d, f(std::size_t{0}));
#else
  const hn::Half<RayLanes> half;
  return hn::Combine(d, hn::DemoteTo(half, f(hn::Lanes(half))), hn::DemoteTo(half, f(std::size_t{0})));
#endif
}

/// One half of a vector of rays: from lane 0 on, or from the middle on.
HWY_INLINE auto half_as_doubles(RayVector values, std::size_t lane) {
#if HWY_TARGET == HWY_SCALAR
  (void)lane;
  return hn::PromoteTo(hn::Rebind<double, RayLanes>(), values);
#else
  const hn::Half<RayLanes> half;
  const hn::Rebind<double, decltype(half)> doubles;
  return hn::PromoteTo(doubles, lane == 0 ? hn::LowerHalf(half, values) : hn::UpperHalf(half, values));
#endif
}

/// A vector of rays of a packet as they enter a leaf, from the corner of its frame.
struct PacketGroup {
  std::size_t first;  ///< lane of the packet
  RayVector t_near, from[3], along[3];
  hn::Mask<RayLanes> meets;

  HWY_INLINE auto world_t(const PacketRays& rays, std::size_t lane) const {
    const auto t = half_as_doubles(t_near, lane);
    return hn::Add(t, hn::Load(hn::DFromV<decltype(t)>(), rays.shift + first + lane));
  }

  /// corner: of the frame, world.
  HWY_INLINE PacketGroup(const PacketRays& rays, const double* corner, std::size_t first_lane, RayVector t,
                         hn::Mask<RayLanes> meets_leaf)
      : first(first_lane), t_near(t), meets(meets_leaf) {
    const RayLanes d;
    for (int axis = 0; axis < 3; ++axis) {
      from[axis] = from_doubles([&](std::size_t lane) {
        const auto position = world_t(rays, lane);
        const hn::DFromV<decltype(position)> doubles;
        return hn::Sub(hn::MulAdd(position, hn::Load(doubles, rays.direction[axis] + first + lane),
                                  hn::Load(doubles, rays.origin[axis] + first + lane)),
                       hn::Set(doubles, corner[axis]));
      });
      along[axis] = hn::Load(d, rays.along[axis] + first);
    }
    // Lanes of other rays are no numbers, so that no comparison of theirs is true.
    from[0] = hn::IfThenElse(meets, from[0], hn::NaN(d));
  }
};

/// Where a point lies on a ray: t from where the ray enters the leaf; above 0, `inside` is the square of half
/// the chord of the widened sphere.
struct PointAtRay {
  RayVector t, inside;
};

/// x, y, z: of the point from where the ray enters the leaf; outer: the square of the widened radius.
HWY_INLINE PointAtRay point_at_ray(RayVector x, RayVector y, RayVector z, RayVector along_x,
                                   RayVector along_y, RayVector along_z, RayVector outer) {
  const auto t = hn::MulAdd(z, along_z, hn::MulAdd(y, along_y, hn::Mul(x, along_x)));
  const auto across_x = hn::NegMulAdd(t, along_x, x), across_y = hn::NegMulAdd(t, along_y, y),
             across_z = hn::NegMulAdd(t, along_z, z);
  return {t, hn::NegMulAdd(across_x, across_x,
                           hn::NegMulAdd(across_y, across_y, hn::NegMulAdd(across_z, across_z, outer)))};
}

/// PointAtRay::inside of a point that certainly is within its radius is at least this; infinite if no point
/// is certain. inner_sq: below 0 then. The addition is for the rounding.
inline float sure_inside(float outer_sq, float inner_sq) {
  if (inner_sq < 0.0f) return std::numeric_limits<float>::infinity();
  return (outer_sq - inner_sq) * k_up + outer_sq * 0x1p-20f;
}

/// Limits of t and entry from where rays enter a leaf.
struct PacketLimits {
  RayVector t_low, t_high, sure_low, sure_high;
  RayVector entry_low, sure_entry;  ///< with twice the error: the point's and the limit's
  bool has_entry_min;

  PacketLimits() = default;

  PacketLimits(const PacketRays& rays, const QueryConditions& query, float leaf_error,
               const PacketGroup& group)
      : has_entry_min(query.entry_min > -std::numeric_limits<double>::infinity()) {
    const RayLanes d;
    const auto error = hn::Set(d, leaf_error);
    const auto relative = [&](const double* limits) {
      return from_doubles([&](std::size_t lane) {
        const auto t = half_as_doubles(group.t_near, lane);
        return hn::Sub(hn::Load(hn::DFromV<decltype(t)>(), limits + group.first + lane), t);
      });
    };
    const auto t_min = relative(rays.t_min), t_max = relative(rays.t_max);
    const auto entry_min = from_doubles([&](std::size_t lane) {
      const auto t = group.world_t(rays, lane);
      const hn::DFromV<decltype(t)> doubles;
      const auto far = hn::Set(doubles, k_far);
      return hn::Min(hn::Max(hn::Sub(hn::Set(doubles, query.entry_min), t), hn::Neg(far)), far);
    });
    t_low = hn::Sub(t_min, error);
    t_high = hn::Add(t_max, error);
    sure_low = hn::Add(t_min, error);
    sure_high = hn::Sub(t_max, error);
    const auto both = hn::Add(error, error);
    entry_low = hn::Sub(entry_min, both);
    sure_entry = hn::Add(entry_min, both);
  }

  /// What limits leave of possible and certain points. By entry_min a point is only discarded where the upper
  /// bound of its entry is known: near the rim (`inside` below `rim`) the lower bound lies far below the
  /// entry. With a = t - entry_min, the entry t - sqrt(c) of a half chord squared c is before entry_min where
  /// a < 0 or a^2 < c: no roots.
  HWY_INLINE void apply(RayVector t, RayVector inside, RayVector rim, hn::Mask<RayLanes>& is_possible,
                        hn::Mask<RayLanes>& is_sure) const {
    const RayLanes d;
    is_possible = hn::And(is_possible, hn::And(hn::Ge(t, t_low), hn::Le(t, t_high)));
    is_sure = hn::And(is_sure, hn::And(hn::Ge(t, sure_low), hn::Le(t, sure_high)));
    if (!has_entry_min) return;
    const auto zero = hn::Zero(d);
    const auto most = hn::Sub(t, entry_low);
    const auto is_before =
        hn::Or(hn::Lt(most, zero), hn::Gt(inside, hn::Mul(hn::MulAdd(most, most, rim), hn::Set(d, k_up))));
    is_possible = hn::AndNot(hn::And(hn::Ge(inside, rim), is_before), is_possible);
    is_sure = hn::And(is_sure, enters_after(d, hn::Sub(t, sure_entry), inside));
  }
};

/// Limits of single rays of a group, for lanes of points.
struct PacketLimitsByRay {
  static_assert(std::is_same_v<PointLanes, RayLanes>);
  static constexpr RayVector PacketLimits::*k_members[] = {
      &PacketLimits::t_low,     &PacketLimits::t_high,    &PacketLimits::sure_low,
      &PacketLimits::sure_high, &PacketLimits::entry_low, &PacketLimits::sure_entry};
  alignas(64) float values[std::size(k_members)][PacketRays::k_most_lanes];
  bool has_entry_min;

  explicit PacketLimitsByRay(const PacketLimits& limits) : has_entry_min(limits.has_entry_min) {
    for (std::size_t i = 0; i < std::size(k_members); ++i)
      hn::Store(limits.*k_members[i], RayLanes(), values[i]);
  }
  HWY_INLINE PacketLimits of(std::size_t lane) const {
    PacketLimits limits;
    for (std::size_t i = 0; i < std::size(k_members); ++i)
      limits.*k_members[i] = hn::Set(RayLanes(), values[i][lane]);
    limits.has_entry_min = has_entry_min;
    return limits;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
