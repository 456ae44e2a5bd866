// SPDX-License-Identifier: MIT
// Included once per instruction set by Highway: no #pragma once.
#if defined(ALIDADE_SIMD_DISC_TEST_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ALIDADE_SIMD_DISC_TEST_INL_H
#undef ALIDADE_SIMD_DISC_TEST_INL_H
#else
#define ALIDADE_SIMD_DISC_TEST_INL_H
#endif

#include "octree/packed_surface.h"
#include "octree/simd/lanes-inl.h"
#include "octree/simd/ray_state.h"

HWY_BEFORE_NAMESPACE();
namespace alidade::simd {
namespace HWY_NAMESPACE {

/// Points near a ray, in lanes: their offset from a point of it, the t of their projection and the square of
/// their distance, each within `error`; `outer` is their radius and the error, or more.
struct NearRay {
  using V = hn::Vec<PointLanes>;
  V x, y, z;
  V t, distance_sq;
  V error, outer_sq, radius;
};

/// Bounds of the t at which the ray crosses each of them, if it does.
struct Crossings {
  hn::Vec<PointLanes> low, high;
};

/// Where rays cross the discs of points, and enter the spheres of those without a sheet
/// (evaluate_crossing()).
///
/// With the normal m, not yet of length 1, the height h and the direction d:
///
///   t = (p m - h |m|) / (d m)
///
/// Components of m err by less than 2^-21, and so do |m| and d m, within a few roundings; `error` exceeds
/// 2^-18 (|p| + radius). So the numerator errs by less than 3 error + 2^-20 h, the denominator by less than
/// 2^-19; the budgets are 4 error + 2^-18 h and 2^-18. Where the ray runs along the plane all is possible
/// that the sphere admits.
class DiscTest {
 public:
  explicit DiscTest(const QuerySetup& setup)
      : surfaces_(setup.tree.stored_surfaces),
        unit_(static_cast<float>(setup.tree.surface_unit)),
        lone_share_(setup.query.spacing_factor > 0.0
                        ? float_above(std::min(setup.query.lone_factor / setup.query.spacing_factor, 1.0))
                        : 0.0f),
        lone_radius_(float_above(std::min(setup.query.lone_radius, setup.query.radius))) {}

  /// along: the ray's direction. Points from this storage index on.
  HWY_INLINE Crossings operator()(std::uint32_t index, const NearRay& points, const float* along) const {
    const PointLanes d;
    using V = hn::Vec<PointLanes>;
    const hn::RebindToUnsigned<PointLanes> bits;
    const auto packed = hn::LoadU(bits, surfaces_ + index);
    const V one = hn::Set(d, 1.0f), zero = hn::Zero(d), half = hn::Set(d, 0.5f);
    const auto side = [&](auto shifted) {
      const auto steps = hn::And(shifted, hn::Set(bits, packed_surface::k_side_mask));
      return hn::MulSub(as_float(steps), hn::Set(d, static_cast<float>(2.0 / packed_surface::k_side_steps)),
                        one);
    };
    const V u = side(hn::ShiftRight<packed_surface::k_first_side>(packed)),
            v = side(hn::ShiftRight<packed_surface::k_second_side>(packed));
    const V mx = hn::Mul(half, hn::Add(u, v)), my = hn::Mul(half, hn::Sub(u, v)),
            mz = hn::Sub(one, hn::Add(hn::Abs(mx), hn::Abs(my)));
    const V length = hn::Sqrt(hn::MulAdd(mx, mx, hn::MulAdd(my, my, hn::Mul(mz, mz))));
    const V height = height_of(packed);
    const V across = hn::MulAdd(
        points.x, mx, hn::MulAdd(points.y, my, hn::NegMulAdd(height, length, hn::Mul(points.z, mz))));
    const V slope = hn::MulAdd(hn::Set(d, along[0]), mx,
                               hn::MulAdd(hn::Set(d, along[1]), my, hn::Mul(hn::Set(d, along[2]), mz)));
    const V steepness = hn::Abs(slope), t = hn::Div(across, slope);
    const V slope_error = hn::Set(d, 0x1p-18f);
    const V wrong = hn::MulAdd(hn::Set(d, 4.0f), points.error,
                               hn::MulAdd(hn::Abs(height), slope_error, hn::Mul(hn::Abs(t), slope_error)));
    const V error = hn::Div(hn::Mul(hn::Set(d, 2.0f), wrong), steepness);

    const V half_chord = hn::Sqrt(hn::Max(hn::Sub(points.outer_sq, points.distance_sq), zero));
    const V enters = hn::Sub(hn::Sub(points.t, points.error), half_chord),
            leaves = hn::Add(hn::Add(points.t, points.error), half_chord);
    const auto grazes = hn::Not(hn::Gt(steepness, hn::Set(d, 8.0f * 0x1p-18f)));
    const V low = hn::IfThenElse(grazes, enters, hn::Max(hn::Sub(t, error), enters)),
            high = hn::IfThenElse(grazes, leaves, hn::Min(hn::Add(t, error), leaves));

    const V lone = hn::Add(hn::Min(hn::Mul(points.radius, hn::Set(d, lone_share_)), hn::Set(d, lone_radius_)),
                           points.error);
    const V lone_chord_sq = hn::Sub(hn::Mul(hn::Mul(lone, lone), hn::Set(d, k_up)), points.distance_sq);
    const auto meets_lone = hn::Ge(lone_chord_sq, zero);
    const V lone_low = hn::Sub(hn::Sub(points.t, points.error), hn::Sqrt(hn::Max(lone_chord_sq, zero)));
    const V never = hn::Set(d, std::numeric_limits<float>::infinity());
    const auto exists = hn::RebindMask(d, hn::TestBit(packed, hn::Set(bits, packed_surface::k_exists)));
    return {hn::IfThenElse(exists, low, hn::IfThenElse(meets_lone, lone_low, never)),
            hn::IfThenElse(exists, high, hn::Add(points.t, points.error))};
  }

 private:
  using Bits = hn::Vec<hn::RebindToUnsigned<PointLanes>>;

  static HWY_INLINE hn::Vec<PointLanes> as_float(const Bits& whole) {
    const hn::RebindToSigned<PointLanes> ints;
    return hn::ConvertTo(PointLanes(), hn::BitCast(ints, whole));
  }

  /// packed_surface::k_lengths by its law, with the sign.
  HWY_INLINE hn::Vec<PointLanes> height_of(const Bits& packed) const {
    const PointLanes d;
    const hn::RebindToUnsigned<PointLanes> bits;
    const auto all = hn::Set(bits, packed_surface::k_length_mask);
    const auto number = hn::And(hn::ShiftRight<packed_surface::k_height>(packed), all);
    constexpr std::uint32_t k_exponent = 127 + 2;  // of the greatest length
    static_assert(packed_surface::k_greatest_length == 4.0);
    const auto exponent = hn::Sub(hn::Set(bits, k_exponent), hn::ShiftRight<1>(hn::Sub(all, number)));
    const auto whole = hn::BitCast(d, hn::ShiftLeft<23>(exponent));
    const auto is_whole = hn::RebindMask(d, hn::TestBit(number, hn::Set(bits, 1u)));
    const auto length = hn::IfThenElse(
        is_whole, whole, hn::Mul(whole, hn::Set(d, static_cast<float>(packed_surface::k_root_of_half))));
    const auto is_zero = hn::RebindMask(d, hn::Eq(number, hn::Zero(bits)));
    const auto sized = hn::Mul(hn::IfThenZeroElse(is_zero, length), hn::Set(d, unit_));
    const auto below = hn::RebindMask(d, hn::TestBit(packed, hn::Set(bits, packed_surface::k_below)));
    return hn::IfThenElse(below, hn::Neg(sized), sized);
  }

  const std::uint32_t* const surfaces_;
  const float unit_;
  const float lone_share_, lone_radius_;
};

}  // namespace HWY_NAMESPACE
}  // namespace alidade::simd
HWY_AFTER_NAMESPACE();

#endif
